"""A thing that moves in the picture: its exact cover, its light in colour, and how both are laid on the picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.body import Part, Solid
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.rendering import FILL_EXCESS_PX, Box, Outlines, box_around, coverage, project
from local_site.simulation.room.shading import Lamps, SeenBalls, shade
from local_site.simulation.room.surface import Coat

Field = NDArray[np.float32]

SPILL_PX = 1.5
GAMMA = 2.2
STEPS = 1024


@dataclass(frozen=True, slots=True)
class Body:
    """A solid of `parts` at one instant: its balls, and the M balls between them (`weights` (M, N + 1)) with their
    coat; `backs` (N, 3) in the operator frame."""

    solid: Solid
    parts: tuple[Part, ...]
    weights: Array
    backs: Array
    coat: Coat


def lay_on(image: Image, exposures: Sequence[Body], camera: PinholeCamera, lamps: Lamps, blur_sigma_px: float) -> None:
    """Draw a body, seen at instants spread over one exposure, on a BGR picture (H, W, 3)."""
    outlines = [project(body.solid, camera, FILL_EXCESS_PX) for body in exposures]
    box = box_around(outlines, int(np.ceil(3.0 * blur_sigma_px)) + 2, (image.shape[1], image.shape[0]))
    if box is None:
        return
    light, cover = _mean_layer(exposures, outlines, camera, lamps, box)
    if blur_sigma_px:
        light = _as_field(cv2.GaussianBlur(light, (0, 0), blur_sigma_px))
        cover = _as_field(cv2.GaussianBlur(cover, (0, 0), blur_sigma_px))
    left, top, right, bottom = box
    region = image[top:bottom, left:right]
    through = cv2.merge([1.0 - cover] * 3)
    region[:] = cv2.convertScaleAbs(cv2.add(cv2.multiply(region, through, dtype=cv2.CV_32F), light))


def _mean_layer(
    exposures: Sequence[Body], outlines: Sequence[Outlines], camera: PinholeCamera, lamps: Lamps, box: Box
) -> tuple[Field, Field]:
    """Levels (H, W, 3), 0 to 255, times cover, and the cover (H, W), 0 to 1."""
    left, top, right, bottom = box
    light = np.zeros((bottom - top, right - left, 3), np.float32)
    cover = np.zeros((bottom - top, right - left), np.float32)
    for body, outline in zip(exposures, outlines, strict=True):
        own = _as_field(coverage(outline, body.parts, box) * np.float32(1.0 / (255.0 * len(exposures))))
        light += _levels(body, camera, lamps, box) * own[:, :, None]
        cover += own
    return light, cover


def _levels(body: Body, camera: PinholeCamera, lamps: Lamps, box: Box) -> Field:
    """What the body looks like (H, W, 3), 0 to 255, a few pixels beyond its outline too."""
    left, top, right, bottom = box
    light, seen = shade(_seen(body, camera, box), body.coat, lamps, right - left, bottom - top)
    spilled = cv2.GaussianBlur(light, (0, 0), SPILL_PX)
    share = np.maximum(cv2.GaussianBlur(seen, (0, 0), SPILL_PX), np.float32(1e-3))
    levels = np.where(seen[:, :, None] > 0.0, light, spilled / share[:, :, None])
    steps = np.minimum(levels * np.float32(STEPS), np.float32(2 * STEPS - 1)).astype(np.int32)
    return _as_field(_EXPOSED[steps])


def _seen(body: Body, camera: PinholeCamera, box: Box) -> SeenBalls:
    solid = body.solid
    sleeve = solid.rim.mean(axis=0)
    centres = np.vstack([solid.centres, sleeve])
    radii = np.append(solid.radii, np.linalg.norm(solid.rim - sleeve, axis=1).min())
    backs = np.vstack([body.backs, np.zeros(3)])
    between, radius = camera.to_camera(body.weights @ centres), body.weights @ radii
    distance = np.linalg.norm(between, axis=1)
    turned = (body.weights @ backs) @ camera.camera_R_operator.T
    turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-6)
    radius_px = camera.focal_px * radius / between[:, 2]
    return SeenBalls(camera.pixels(between) - np.array(box[:2]), radius_px, distance, radius, turned)


def _as_field(picture: object) -> Field:
    return np.asarray(picture, dtype=np.float32)


_EXPOSED = np.asarray(255.0 * np.minimum(np.arange(2 * STEPS) / STEPS, 1.0) ** (1.0 / GAMMA), np.float32)
