"""A body that moves in the picture: its exact cover, what it looks like, and how both are laid on the picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.body import Part, Solid
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.rendering import FILL_EXCESS_PX, Box, Outlines, box_around, coverage, mean_picture, project
from local_site.simulation.room.shading import SeenBalls, Shader, lay_on
from local_site.simulation.room.surface import Coat


@dataclass(frozen=True, slots=True)
class Body:
    """A solid of `parts` at one instant: its balls, and the M balls between them (`weights` (M, N + 1)) with their
    coat; `backs` (N, 3) in the operator frame."""

    solid: Solid
    parts: tuple[Part, ...]
    weights: Array
    backs: Array
    coat: Coat


def draw(image: Image, exposures: Sequence[Body], camera: PinholeCamera, shader: Shader, blur_sigma_px: float) -> None:
    """Draw a body, seen at instants spread over one exposure, on a BGR picture (H, W, 3)."""
    outlines = [project(body.solid, camera, FILL_EXCESS_PX) for body in exposures]
    box = box_around(outlines, int(np.ceil(3.0 * blur_sigma_px)) + 2, (image.shape[1], image.shape[0]))
    if box is None:
        return
    seen = zip(exposures, outlines, strict=True)
    layer = mean_picture([_layer(body, outline, camera, shader, box) for body, outline in seen])
    if blur_sigma_px:
        cv2.GaussianBlur(layer, (0, 0), blur_sigma_px, dst=layer)
    left, top, right, bottom = box
    lay_on(image[top:bottom, left:right], layer)


def _layer(body: Body, outlines: Outlines, camera: PinholeCamera, shader: Shader, box: Box) -> Image:
    return shader.shade(_seen(body, camera, box), body.coat, coverage(outlines, body.parts, box))


def _seen(body: Body, camera: PinholeCamera, box: Box) -> SeenBalls:
    solid = body.solid
    sleeve = solid.rim.mean(axis=0)
    centres = np.vstack([solid.centres, sleeve])
    radii = np.append(solid.radii, np.linalg.norm(solid.rim - sleeve, axis=1).min())
    backs = np.vstack([body.backs, np.zeros(3)])
    between, radius = camera.to_camera(body.weights @ centres), body.weights @ radii
    turned = (body.weights @ backs) @ camera.camera_R_operator.T
    turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-6)
    radius_px = camera.focal_px * radius / between[:, 2]
    centres_px = camera.pixels(between) - np.array(box[:2])
    return SeenBalls(centres_px, radius_px, np.linalg.norm(between, axis=1), radius, turned)
