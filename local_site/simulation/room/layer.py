"""A body that moves in the picture: its cover, its look in the office's light, and how both are laid on a picture."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.body import Part, Solid
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.rendering import FILL_EXCESS_PX, Box, Outlines, box_around, coverage, mean_picture, project
from local_site.simulation.room.shading import Lamps, SeenBalls, Shader, lay_on
from local_site.simulation.room.surface import Coat

# To the lamps, in the operator frame: tubes above and before the operator; a window at the operator's left.
DIRECTIONS = np.array([[-0.25, -0.60, 0.76], [0.85, -0.35, 0.40]])
COLOURS = np.array([[0.50, 0.54, 0.56], [0.20, 0.17, 0.15]])  # blue, green, red
AMBIENT = np.array([0.33, 0.33, 0.34])
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class ShadedBody:
    """A solid of `parts` at one instant: its balls, and the M balls between them (`weights` (M, N + 1)) with their
    coat; `backs` (N, 3) in the operator frame."""

    solid: Solid
    parts: tuple[Part, ...]
    weights: Array
    backs: Array
    coat: Coat


@dataclass(frozen=True, slots=True)
class ShadedLayer:
    """A picture to lay on a box of another: (H, W, 4), BGR times cover, and cover."""

    box: Box
    picture: Image

    def lay_on(self, image: Image) -> None:
        """Lay it on a BGR picture (H, W, 3)."""
        left, top, right, bottom = self.box
        lay_on(image[top:bottom, left:right], self.picture)


class Brush:
    """Draws bodies on the pictures of one camera of `size` (W, H)."""

    def __init__(self, camera: PinholeCamera, size: tuple[int, int], blur_sigma_px: float) -> None:
        self._camera, self._size, self._blur_px = camera, size, blur_sigma_px
        self._shader = Shader(_lamps(camera.camera_R_operator), size)

    def draw(self, image: Image, exposures: Sequence[ShadedBody]) -> None:
        """Draw a body, seen at instants spread over one exposure, on a BGR picture (H, W, 3)."""
        layer = self.layer(exposures)
        if layer is not None:
            layer.lay_on(image)

    def layer(self, exposures: Sequence[ShadedBody]) -> "ShadedLayer | None":
        """Return what `draw` lays on the picture, to be kept while nothing moves; None when it is out of view."""
        outlines = [project(body.solid, self._camera, FILL_EXCESS_PX) for body in exposures]
        box = box_around(outlines, int(np.ceil(3.0 * self._blur_px)) + 2, self._size)
        if box is None:
            return None
        seen = zip(exposures, outlines, strict=True)
        picture = mean_picture([self._shade(body, outline, box) for body, outline in seen])
        if self._blur_px:
            cv2.GaussianBlur(picture, (0, 0), self._blur_px, dst=picture)
        return ShadedLayer(box, picture)

    def _shade(self, body: ShadedBody, outlines: Outlines, box: Box) -> Image:
        return self._shader.shade(_seen(body, self._camera, box), body.coat, coverage(outlines, body.parts, box))


def _lamps(camera_R_operator: Array) -> Lamps:
    directions = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
    return Lamps(directions @ camera_R_operator.T, COLOURS, AMBIENT, camera_R_operator @ UP)


def _seen(body: ShadedBody, camera: PinholeCamera, box: Box) -> SeenBalls:
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
