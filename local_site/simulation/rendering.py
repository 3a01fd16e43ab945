"""Draws the simulated arm grey on black, with the blur and the noise of a real camera."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from local_site.simulation.body import Part, Solid
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import PictureConfig, StereoConfig
from local_site.simulation.outline import PartOutline, part_outlines

FINE = 4
SHIFT = 4
# OpenCV fills every pixel that the outline touches: 0.47 of a fine pixel too much all round, as measured on circles.
FILL_EXCESS_PX = 0.47 / FINE
MARGIN_PX = 12
NOISE_ROOM_PX = 128

BACKGROUND_LEVEL = 9.0
BACKGROUND_RELIEF = 4.0
RIM_LEVEL = 96
PEAK_LEVEL = 190
FULL_DEPTH_PX = 18.0


class Renderer:
    """One camera's picture of the arm; its noise is drawn once and shifted about at random from frame to frame."""

    def __init__(
        self, camera: PinholeCamera, parts: tuple[Part, ...], stereo: StereoConfig, picture: PictureConfig, seed: int
    ) -> None:
        self._camera = camera
        self._parts = parts
        self._size = (stereo.width_px, stereo.height_px)
        self._picture = picture
        self._random = np.random.default_rng(seed)
        self._background = _background(*self._size, self._random)
        self._noise = _noise(*self._size, picture.noise_sigma, seed)

    def render(self, exposures: list[Solid]) -> Image:
        """The picture (H, W) grey of the arm as it was at instants spread over one exposure."""
        outlines = [part_outlines(solid, self._parts, self._camera, FILL_EXCESS_PX) for solid in exposures]
        image = self._background.copy()
        box = _box(outlines, self._size)
        if box is not None:
            left, top, right, bottom = box
            region = image[top:bottom, left:right]
            cv2.add(region, self._arm(outlines, box), dst=region)
        return self._with_noise(image)

    def _arm(self, outlines: list[list[PartOutline]], box: tuple[int, int, int, int]) -> Image:
        pictures = [_draw(parts, box) for parts in outlines]
        arm = pictures[0] if len(pictures) == 1 else np.mean(pictures, axis=0).astype(np.uint8)
        if self._picture.blur_sigma_px:
            arm = cv2.GaussianBlur(arm, (0, 0), self._picture.blur_sigma_px)
        return arm

    def _with_noise(self, image: Image) -> Image:
        if not self._picture.noise_sigma:
            return image
        x, y = self._random.integers(0, NOISE_ROOM_PX, size=2)
        width, height = self._size
        return cv2.add(image, self._noise[y : y + height, x : x + width], dtype=cv2.CV_8U)


def _draw(parts: list[PartOutline], box: tuple[int, int, int, int]) -> Image:
    """The arm within the box (left, top, right, bottom), lit from the front, without its background."""
    left, top, right, bottom = box
    size = (right - left, bottom - top)
    corner = np.array([left, top], np.float32)
    fine = np.zeros((FINE * size[1], FINE * size[0]), np.uint8)
    relief = np.zeros(size[::-1], np.uint8)
    for part in parts:
        polygons = [polygon - corner for polygon in part.polygons]
        coarse = [_fixed(polygon) for polygon in polygons]
        cv2.polylines(relief, coarse, True, 0, 2, cv2.LINE_8, SHIFT)
        for polygon, outline in zip(polygons, coarse, strict=True):
            cv2.fillConvexPoly(relief, outline, 255, cv2.LINE_8, SHIFT)
            cv2.fillConvexPoly(fine, _fixed(FINE * polygon + (FINE - 1) / 2), 255, cv2.LINE_8, SHIFT)
    coverage = cv2.resize(fine, size, interpolation=cv2.INTER_AREA)
    return cv2.multiply(_shade(relief), coverage, scale=1 / 255)


def _shade(relief: Image) -> Image:
    """Brightness of each pixel by its depth inside the nearest outline, as if every limb were round."""
    depth = cv2.distanceTransform(relief, cv2.DIST_L2, cv2.DIST_MASK_3)
    level = cv2.LUT(cv2.convertScaleAbs(depth, alpha=255 / FULL_DEPTH_PX), _ROUND)
    return cv2.GaussianBlur(level, (0, 0), 1.0)


def _round_levels() -> Image:
    share = np.arange(256) / 255
    return (RIM_LEVEL + (PEAK_LEVEL - RIM_LEVEL) * np.sqrt(1 - (1 - share) ** 2)).astype(np.uint8)


_ROUND = _round_levels()


def _fixed(polygon: NDArray[np.float32]) -> NDArray[np.int32]:
    """Pixel coordinates with the fractional bits that OpenCV takes."""
    return np.rint(polygon * (1 << SHIFT)).astype(np.int32)


def _box(exposures: list[list[PartOutline]], size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """The part of the picture (left, top, right, bottom) that the arm fills, or None when it is out of view."""
    points = np.concatenate([polygon for parts in exposures for part in parts for polygon in part.polygons])
    low = np.maximum(np.floor(points.min(axis=0)).astype(int) - MARGIN_PX, 0)
    high = np.minimum(np.ceil(points.max(axis=0)).astype(int) + MARGIN_PX, size)
    if np.any(high - low < 2):
        return None
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _background(width: int, height: int, random: np.random.Generator) -> Image:
    """Black cloth: a faint gradient with soft folds."""
    folds = cv2.resize(random.uniform(-1.0, 1.0, (5, 6)), (width, height), interpolation=cv2.INTER_CUBIC)
    gradient = np.linspace(-0.5, 0.5, height)[:, None]
    return np.clip(BACKGROUND_LEVEL + BACKGROUND_RELIEF * (0.5 * folds + gradient), 0, 255).astype(np.uint8)


def _noise(width: int, height: int, sigma: float, seed: int) -> NDArray[np.int16]:
    field = np.zeros((height + NOISE_ROOM_PX, width + NOISE_ROOM_PX), np.int16)
    cv2.setRNGSeed(seed % 2**31)
    cv2.randn(field, 0, sigma)
    return field
