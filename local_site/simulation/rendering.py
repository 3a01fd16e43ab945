"""Draws the simulated arm grey on black by its exact outline, with the blur and the noise of a real camera."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.kernels.filling import FixedPoints, Numbers, convex_hulls, fill_hulls
from local_site.simulation.body import RIM_POINTS, Part, Solid
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import PictureConfig, StereoConfig

Box = tuple[int, int, int, int]

FINE = 4
SHIFT = 4
COARSE_SHIFT = SHIFT + 2
# OpenCV fills every pixel that the outline touches: 0.47 of a fine pixel too much all round, as measured on circles.
FILL_EXCESS_PX = 0.47 / FINE
NOISE_ROOM_PX = 128

BACKGROUND_LEVEL = 9.0
BACKGROUND_RELIEF = 4.0
RIM_LEVEL = 96
PEAK_LEVEL = 190
FULL_DEPTH_PX = 18.0
ONE = 1 << 16  # pixel deep, in fixed point
STRAIGHT, DIAGONAL, FAR = round(0.955 * ONE), round(1.3693 * ONE), 1 << 28
GLOVE_LEVEL = 22
MARKER_LEVEL = 225

JUST_M = 1e-6
_TURN = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
# Half way between inscribed and circumscribed, so that a polygon of few corners is as wide as its circle on average.
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)]) * (0.5 + 0.5 / np.cos(np.pi / RIM_POINTS))


@dataclass(frozen=True, slots=True)
class Outlines:
    """The outlines of N balls, the sleeve's rim and K markers in the lens: `rims` (N + 1 + K, RIM_POINTS, 2) in px.

    `depths` (N + 1 + K,) are the distances of their centres along the line of sight, m.
    """

    rims: Array
    depths: Array


def project(solid: Solid, camera: PinholeCamera, inset_px: float = 0.0) -> Outlines:
    """The outlines of all balls in one camera, each smaller all round by `inset_px`; exact, since a hull of balls
    projects to the hull of their outlines."""
    count, worn = len(solid.radii), len(solid.markers)
    points = camera.to_camera(np.concatenate([solid.centres, solid.markers, solid.rim]))
    centres, rim = points[: count + worn], points[count + worn :]
    full = np.concatenate([solid.radii, np.full(worn, solid.marker_radius)])
    balls = _ball_outlines(centres, full - inset_px / camera.focal_px * centres[:, 2], _CIRCLE)
    rims = camera.pixels(np.concatenate([balls[:count], rim[None], balls[count:]]))
    depths = centres[:, 2]
    return Outlines(rims, np.concatenate([depths[:count], [rim[:, 2].mean()], depths[count:]]))


def part_hulls(rims: FixedPoints, parts: Sequence[Part]) -> tuple[Numbers, Numbers]:
    """The hulls of all pieces of parts, as by `convex_hulls`; those of a part are together its silhouette."""
    sizes = np.concatenate([part.sizes for part in parts])
    points = rims[np.concatenate([part.balls for part in parts])]
    return convex_hulls(points.reshape(-1, 2), points.shape[1] * np.cumsum(sizes))


def farthest_first(depths: Array, parts: tuple[Part, ...]) -> list[Part]:
    """The parts in the order in which to draw them: a marker just before or just after the limb that wears it."""
    return sorted(parts, key=lambda part: -_distance(depths, part))


def _distance(depths: Array, part: Part) -> float:
    if part.worn_on is None:
        return float(depths[part.balls].mean())
    limb, ball = part.worn_on
    behind = depths[part.balls[0]] > depths[ball] + JUST_M
    return _distance(depths, limb) + (JUST_M if behind else -JUST_M)


@compiled
def _ball_outlines(centres: Array, radii: Array, circle: Array) -> Array:
    """The circles (N, RIM_POINTS, 3) along which lines of sight touch the balls, in the camera's frame."""
    touching = np.empty((len(centres), len(circle), 3))
    for n in range(len(centres)):
        x, y, z = centres[n]
        distance = np.sqrt(x * x + y * y + z * z)
        shrink = 1.0 - (radii[n] / distance) ** 2
        x, y, z = x / distance, y / distance, z / distance
        radius = radii[n] * np.sqrt(shrink / (x * x + z * z))
        for k in range(len(circle)):
            # Along two axes across the line of sight: (z, 0, -x) and its cross product with the sight.
            a, b = radius * circle[k, 0], radius * circle[k, 1]
            touching[n, k, 0] = shrink * centres[n, 0] + a * z - b * x * y
            touching[n, k, 1] = shrink * centres[n, 1] + b * (x * x + z * z)
            touching[n, k, 2] = shrink * centres[n, 2] - a * x - b * y * z
    return touching


class Renderer:
    """One camera's picture of the arm; its noise is drawn once and shifted about at random from frame to frame."""

    def __init__(
        self,
        camera: PinholeCamera,
        parts: tuple[Part, ...],
        stereo: StereoConfig,
        picture: PictureConfig,
        seed: int,
    ) -> None:
        self._camera = camera
        self._parts = parts
        self._size = (stereo.width_px, stereo.height_px)
        self._picture = picture
        self._margin_px = math.ceil(3.0 * picture.blur_sigma_px) + 2
        self._random = np.random.default_rng(seed)
        self._background = _background(*self._size, self._random)
        noise = np.zeros((stereo.height_px + NOISE_ROOM_PX, stereo.width_px + NOISE_ROOM_PX), np.int16)
        cv2.setRNGSeed(seed % 2**31)
        cv2.randn(noise, np.zeros(1), np.array([picture.noise_sigma]))
        # Apart, as it takes a fifth of the time to add bytes to a picture.
        self._brighter, self._darker = (np.clip(way * noise, 0, 255).astype(np.uint8) for way in (1, -1))

    def render(self, exposures: list[Solid]) -> Image:
        """The picture (H, W) grey of the arm as it was at instants spread over one exposure."""
        outlines = [project(solid, self._camera, FILL_EXCESS_PX) for solid in exposures]
        image = self._background.copy()
        box = box_around(outlines, self._margin_px, self._size)
        if box is not None:
            left, top, right, bottom = box
            region = image[top:bottom, left:right]
            arm = mean_picture([_draw(outline, self._parts, box) for outline in outlines])
            if self._picture.blur_sigma_px:
                cv2.GaussianBlur(arm, (0, 0), self._picture.blur_sigma_px, dst=arm)
            cv2.add(region, arm, dst=region)
        return self._with_noise(image)

    def _with_noise(self, image: Image) -> Image:
        if not self._picture.noise_sigma:
            return image
        x, y = self._random.integers(0, NOISE_ROOM_PX, size=2)
        width, height = self._size
        here = slice(y, y + height), slice(x, x + width)
        cv2.add(image, self._brighter[here], dst=image)
        cv2.subtract(image, self._darker[here], dst=image)
        return image


def box_around(outlines: list[Outlines], margin_px: int, size: tuple[int, int]) -> Box | None:
    """Left, top, right, bottom of the part of a picture (W, H) that these fill, or None when they are out of view."""
    x, y = np.ascontiguousarray(np.concatenate([outline.rims for outline in outlines]).reshape(-1, 2).T)
    left, top = max(math.floor(x.min()) - margin_px, 0), max(math.floor(y.min()) - margin_px, 0)
    right, bottom = min(math.ceil(x.max()) + margin_px, size[0]), min(math.ceil(y.max()) + margin_px, size[1])
    return (left, top, right, bottom) if right - left >= 2 and bottom - top >= 2 else None


def mean_picture(pictures: list[Image]) -> Image:
    """The mean of pictures of one shape; the picture itself where there is but one."""
    if len(pictures) == 1:
        return pictures[0]
    total = np.zeros(pictures[0].shape, np.float32)
    for picture in pictures:
        cv2.accumulate(picture, total)
    return cv2.convertScaleAbs(total, alpha=1.0 / len(pictures)).astype(np.uint8, copy=False)


def coverage(outlines: Outlines, parts: tuple[Part, ...], box: Box) -> Image:
    """Compute how much of each pixel (H, W) in the box the parts cover together, 0 to 255."""
    fixed, fine = _finely(outlines, box)
    corners, ends = part_hulls(fixed, parts)
    fill_hulls(fine, corners, ends, np.full(len(ends), 255, np.uint8), SHIFT)
    return _coarse(fine)


def _finely(outlines: Outlines, box: Box) -> tuple[FixedPoints, Image]:
    """The outlines in fixed point pixels of an empty picture of the box that is `FINE` times finer."""
    left, top, right, bottom = box
    # Corner (0, 0) of a picture is the centre of its first pixel, at every resolution.
    fixed = np.rint((outlines.rims - (left, top)) * (FINE << SHIFT) + ((FINE - 1) << SHIFT) / 2).astype(np.int32)
    return fixed, np.zeros((FINE * (bottom - top), FINE * (right - left)), np.uint8)


def _draw(outlines: Outlines, parts: tuple[Part, ...], box: Box) -> Image:
    """The arm within the box, lit from the front, without its background."""
    left, top, right, bottom = box
    size = (right - left, bottom - top)
    fixed, fine = _finely(outlines, box)
    ordered = farthest_first(outlines.depths, parts)
    corners, ends = part_hulls(fixed, ordered)
    if any(part.worn_on for part in parts):
        # A dark glove and evenly bright markers, as their foil throws light back.
        levels = [GLOVE_LEVEL if part.worn_on is None else MARKER_LEVEL for part in ordered]
        fill_hulls(fine, corners, ends, _by_piece(levels, ordered), SHIFT)
        return _coarse(fine)
    fill_hulls(fine, corners, ends, np.full(len(ends), 255, np.uint8), SHIFT)
    labels = np.zeros(size[::-1], np.uint8)
    fill_hulls(labels, corners, ends, _by_piece(range(1, len(ordered) + 1), ordered), COARSE_SHIFT)
    return cv2.multiply(_shade(labels), _coarse(fine), scale=1 / 255).astype(np.uint8, copy=False)


def _by_piece(levels: Sequence[int], parts: Sequence[Part]) -> Image:
    """The level of each part for each of its pieces."""
    return np.repeat(np.array(levels, np.uint8), [len(part.pieces) for part in parts])


def _coarse(fine: Image) -> Image:
    """A quarter of the size; halving twice is eight times as fast as a quarter at once."""
    height, width = fine.shape
    half = cv2.resize(fine, (width // 2, height // 2), interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.resize(half, (width // 4, height // 4), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _shade(labels: Image) -> Image:
    """Brightness of each pixel by its depth inside its limb's outline, as if every limb were round."""
    return cv2.sepFilter2D(_levels(labels, _ROUND), -1, _SOFT, _SOFT).astype(np.uint8, copy=False)


@compiled
def _levels(labels: Image, by_depth: Image) -> Image:
    """The level `by_depth` (256,) for each pixel (H, W) of labelled limbs, the last from `FULL_DEPTH_PX` inside on.

    The depth is that of `cv2.distanceTransform` by masks of 3 x 3; a pixel whose neighbour is another limb's has none.
    """
    height, width = labels.shape
    depths = np.zeros((height + 2, width + 2), np.int32)
    depths[0], depths[-1], depths[:, 0], depths[:, -1] = FAR, FAR, FAR, FAR
    for y in range(height):
        for x in range(width):
            label, row, column = labels[y, x], y + 1, x + 1
            if label and (
                labels[max(y - 1, 0), x] == label == labels[min(y + 1, height - 1), x]
                and labels[y, max(x - 1, 0)] == label == labels[y, min(x + 1, width - 1)]
            ):
                straight = min(depths[row - 1, column], depths[row, column - 1]) + STRAIGHT
                diagonal = min(depths[row - 1, column - 1], depths[row - 1, column + 1]) + DIAGONAL
                depths[row, column] = min(straight, diagonal)
    levels = np.full((height, width), by_depth[0], np.uint8)
    for row in range(height, 0, -1):
        for column in range(width, 0, -1):
            depth = depths[row, column]
            if depth > 0:
                straight = min(depths[row + 1, column], depths[row, column + 1]) + STRAIGHT
                diagonal = min(depths[row + 1, column - 1], depths[row + 1, column + 1]) + DIAGONAL
                depths[row, column] = depth = min(depth, straight, diagonal)
                levels[row - 1, column - 1] = by_depth[min(int(depth * (255 / FULL_DEPTH_PX / ONE) + 0.5), 255)]
    return levels


_DEPTH = np.arange(256) / 255
_ROUND = (RIM_LEVEL + (PEAK_LEVEL - RIM_LEVEL) * np.sqrt(1 - (1 - _DEPTH) ** 2)).astype(np.uint8)
# As OpenCV's Gaussian blur by one pixel has them, which takes twice as long.
_SOFT = np.array([1, 14, 62, 102, 62, 14, 1], np.float32) / 256


def _background(width: int, height: int, random: np.random.Generator) -> Image:
    """Black cloth: a faint gradient with soft folds."""
    folds = cv2.resize(random.uniform(-1.0, 1.0, (5, 6)), (width, height), interpolation=cv2.INTER_CUBIC)
    gradient = np.linspace(-0.5, 0.5, height)[:, None]
    return np.clip(BACKGROUND_LEVEL + BACKGROUND_RELIEF * (0.5 * folds + gradient), 0, 255).astype(np.uint8)
