"""Things that move in the room by themselves: a fan whose blades turn, and shadows that pass over everything."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.cameras import PinholeCamera

FAN_AT, FAN_RADIUS_M = np.array([0.95, 1.9, 0.42]), 0.19
BLADES, TURNS_PER_S = 3, 0.9
BLADE_RAD = 1.15
CAGE, BLADE, FOOT = (188, 190, 192), (150, 156, 160), (92, 94, 96)
FOOT_M = 0.40
SHIFT = 4
SHADOW = 0.35
SWAY_S = (7.0, 3.1)


class Fan:
    """A fan on a foot, as it stands on a desk."""

    def __init__(self, camera: PinholeCamera) -> None:
        self._camera = camera

    def stand(self, image: Image) -> None:
        """Draw the foot and the cage."""
        foot = self._fixed(FAN_AT - np.array([[0.0, 0.0, 0.0], [0.0, 0.0, FOOT_M]]))
        thick = max(1, round(0.03 * self._px_per_m))
        cv2.line(image, foot[0].tolist(), foot[1].tolist(), FOOT, thick, cv2.LINE_AA, SHIFT)
        for share in (1.0, 0.66, 0.33):
            ring = self._fixed(_circle(np.linspace(0.0, 2.0 * np.pi, 49), share * FAN_RADIUS_M))
            cv2.polylines(image, [ring], False, CAGE, max(1, round(0.006 * self._px_per_m)), cv2.LINE_AA, SHIFT)

    def move(self, image: Image, filmed_s: float) -> None:
        """Draw the blades as they are now."""
        for k in range(BLADES):
            angle = 2.0 * np.pi * (TURNS_PER_S * filmed_s + k / BLADES)
            arc = _circle(np.linspace(angle, angle + BLADE_RAD, 9), 0.92 * FAN_RADIUS_M)
            blade = self._fixed(np.vstack([FAN_AT, arc]))
            cv2.fillPoly(image, [blade], BLADE, cv2.LINE_AA, SHIFT)

    @property
    def _px_per_m(self) -> float:
        return self._camera.focal_px / float(self._camera.to_camera(FAN_AT)[2])

    def _fixed(self, points: Array) -> NDArray[np.int32]:
        """Points (N, 3) in fixed point pixels (N, 2)."""
        pixels = self._camera.pixels(self._camera.to_camera(points))
        return np.rint(pixels * (1 << SHIFT)).astype(np.int32)


class Shadows:
    """Soft shadows, as of leaves before a window, that pass to and fro over what is behind the operator."""

    def __init__(self, size: tuple[int, int], random: np.random.Generator) -> None:
        self._size = size
        grid = random.standard_normal((9, 11), dtype=np.float32)
        wide = cv2.resize(grid, (3 * size[0] // 2, 3 * size[1] // 2), interpolation=cv2.INTER_CUBIC)
        self._gain = np.asarray(256.0 * (1.0 - SHADOW * np.clip(wide, 0.0, 1.0)), np.uint16)

    def stand(self, image: Image) -> None:
        """None of it keeps still."""

    def move(self, image: Image, filmed_s: float) -> None:
        """Darken the picture where there is shadow now."""
        width, height = self._size
        left, top = (
            round((0.5 + 0.5 * np.sin(2.0 * np.pi * filmed_s / period_s)) * extent / 2)
            for period_s, extent in zip(SWAY_S, self._size, strict=True)
        )
        gain = self._gain[top : top + height, left : left + width, None]
        image[:] = (image * gain // 256).astype(np.uint8)


def _circle(angles: Array, radius_m: float) -> Array:
    """Points (N, 3) on a circle about the fan's axis, which points towards the cameras."""
    circle: Array = FAN_AT + radius_m * np.stack([np.cos(angles), np.zeros_like(angles), np.sin(angles)], axis=-1)
    return circle
