"""A textured arm before one camera: smooth limbs with skin of any pattern, in light from one side, with noise."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.kernels.rasterising import NOTHING, Triangles, rasterise

STATIONS, AROUND = 90, 96
CAP_STATIONS = 8
SKIN_PX_PER_M = 1500.0
FINE = 3
GRAINS = ((1.0, 0.6), (0.45, 0.3), (3.0, 0.5))
TURN = 2.0 * np.pi

Picture = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class TexturedLimb:
    """A limb's true shape: half axes across (x) and deep (y) in m at stations along its z in m, from the joint.

    `level` is its mean grey level where it is no skin, as of a thing that is held.
    """

    along: tuple[float, ...]
    across: tuple[float, ...]
    deep: tuple[float, ...]
    level: float | None = None


@dataclass(frozen=True, slots=True)
class Scenery:
    """The things that no estimator knows: skin, light, wall and noise, in grey levels.

    `light` points from the arm to the lamp in the camera's frame; `ambient` is the fraction of light from all sides.
    """

    contrast: float = 30.0
    grain_m: float = 0.012
    level: float = 135.0
    light: tuple[float, float, float] = (-0.4, -0.6, -0.7)
    ambient: float = 0.6
    wall: float = 70.0
    wall_relief: float = 30.0
    noise: float = 2.0
    seed: int = 7


@dataclass(frozen=True, slots=True)
class LimbPose:
    """A limb's joint (3,) in m and `camera_R_limb` (3, 3)."""

    joint: Array
    rotation: Array


class ArmFilm:
    """Renders grey pictures (H, W) of limbs before a camera of one focal length in px; deterministic by its seed.

    `behind` is the picture (H, W) of what stands behind them; without one it is the scenery's wall.
    """

    def __init__(
        self,
        limbs: Sequence[TexturedLimb],
        focal_px: float,
        size: tuple[int, int],
        scenery: Scenery | None = None,
        fine: int = FINE,
        behind: Picture | None = None,
    ) -> None:
        self._fine = fine
        self._scenery = scenery or Scenery()
        self._random = np.random.default_rng(self._scenery.seed)
        self._focal_px, (self._width, self._height) = focal_px, size
        self._solids = [_solid(limb) for limb in limbs]
        levels = [self._scenery.level if limb.level is None else limb.level for limb in limbs]
        skins = [
            _skin(solid, self._scenery, level, self._random) for solid, level in zip(self._solids, levels, strict=True)
        ]
        tops = np.cumsum([0, *(len(skin) for skin in skins[:-1])])
        widest = max(skin.shape[1] for skin in skins)
        self._skin = np.vstack([np.pad(skin, ((0, 0), (0, widest - skin.shape[1]))) for skin in skins])
        self._skin_px = np.vstack([s.skin + np.array([0.0, top]) for s, top in zip(self._solids, tops, strict=True)])
        counts = np.cumsum([0, *(len(solid.vertices) for solid in self._solids[:-1])])
        self._triangles = np.vstack([s.triangles + n for s, n in zip(self._solids, counts, strict=True)])
        self._background = (
            _background(self._width, self._height, self._scenery, self._random) if behind is None else behind
        )
        light = np.array(self._scenery.light)
        self._light = light / np.linalg.norm(light)

    def render(self, poses: Sequence[LimbPose]) -> Image:
        """The picture of the limbs in these poses."""
        found = list(zip(self._solids, poses, strict=True))
        vertices = np.vstack([solid.vertices @ p.rotation.T + p.joint for solid, p in found])
        normals = np.vstack([solid.normals @ p.rotation.T for solid, p in found])
        middle_px = (self._width - 1) / 2, (self._height - 1) / 2
        pixels = self._focal_px * vertices[:, :2] / vertices[:, 2:] + middle_px
        left, top, right, bottom = self._box(pixels)
        if right <= left or bottom <= top:
            return self._exposed(self._background)
        # Corner (0, 0) of a picture is the centre of its first pixel, at every resolution.
        fine, size = self._fine, (self._fine * (right - left), self._fine * (bottom - top))
        raster = rasterise(
            fine * (pixels - (left, top)) + (fine - 1) / 2, vertices[:, 2].copy(), self._triangles, *size
        )
        seen = raster.triangle != NOTHING
        corners, weights = self._triangles[raster.triangle[seen]], raster.barycentric[seen]
        part = self._background[top:bottom, left:right].repeat(fine, axis=0).repeat(fine, axis=1)
        albedo = _bilinear(self._skin, _mixed(weights, self._skin_px[corners]))
        outward = _mixed(weights, normals[corners])
        facing = np.maximum(outward @ self._light, 0.0) / np.linalg.norm(outward, axis=1)
        part[seen] = albedo * (self._scenery.ambient + (1.0 - self._scenery.ambient) * facing)
        picture = self._background.copy()
        picture[top:bottom, left:right] = cv2.resize(part, (right - left, bottom - top), interpolation=cv2.INTER_AREA)
        return self._exposed(picture)

    def _box(self, pixels: Array) -> tuple[int, int, int, int]:
        """Left, top, right, bottom of the part of the picture that holds all pixels (N, 2)."""
        low = np.clip(np.floor(pixels.min(axis=0)), 0, (self._width, self._height)).astype(int)
        high = np.clip(np.ceil(pixels.max(axis=0)) + 1, 0, (self._width, self._height)).astype(int)
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])

    def _exposed(self, picture: Picture) -> Image:
        if not self._scenery.noise:
            return np.asarray(cv2.convertScaleAbs(picture), dtype=np.uint8)
        noise = self._random.normal(0.0, self._scenery.noise, picture.shape)
        return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


@dataclass(frozen=True, slots=True)
class _LimbSurface:
    """A limb's surface: vertices and normals (V, 3) in its frame, skin positions (V, 2) in px, triangles (T, 3)."""

    vertices: Array
    normals: Array
    skin: Array
    triangles: Triangles


@compiled
def _bilinear(skin: Picture, positions: Array) -> Array:
    """The skin at positions (N, 2) in its px, bilinear."""
    levels = np.empty(len(positions))
    for n in range(len(positions)):
        left, top = int(positions[n, 0]), int(positions[n, 1])
        u, v = positions[n, 0] - left, positions[n, 1] - top
        upper = (1.0 - u) * skin[top, left] + u * skin[top, left + 1]
        lower = (1.0 - u) * skin[top + 1, left] + u * skin[top + 1, left + 1]
        levels[n] = (1.0 - v) * upper + v * lower
    return levels


def _mixed(weights: Array, corners: Array) -> Array:
    result: Array = np.einsum("nk,nkd->nd", weights, corners)
    return result


def _solid(limb: TexturedLimb) -> _LimbSurface:
    """The limb's skin with a seam along its x, and round ends."""
    z, across, deep = _sections(limb)
    turn = np.linspace(0.0, TURN, AROUND + 1)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    halves = np.stack([across, deep], axis=-1)[:, None]
    vertices = np.concatenate([halves * circle, np.broadcast_to(z[:, None, None], (len(z), AROUND + 1, 1))], axis=2)
    around, outward = np.gradient(vertices, axis=1), np.gradient(vertices, axis=0)
    around[:, [0, -1]] = 0.5 * (vertices[:, [1]] - vertices[:, [-2]])
    normals = np.cross(around, outward)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
    girth = TURN * max(*limb.across, *limb.deep)
    skin = np.stack(np.broadcast_arrays(turn[None] / TURN * girth, (z - z[0])[:, None]), axis=-1) * SKIN_PX_PER_M
    a = (np.arange(len(z) - 1)[:, None] * (AROUND + 1) + np.arange(AROUND)).ravel()
    b, c, d = a + 1, a + AROUND + 1, a + AROUND + 2
    triangles = np.vstack([np.column_stack([a, b, d]), np.column_stack([a, d, c])]).astype(np.int32)
    return _LimbSurface(vertices.reshape(-1, 3), normals.reshape(-1, 3), skin.reshape(-1, 2), triangles)


def _sections(limb: TexturedLimb) -> tuple[Array, Array, Array]:
    """Stations along the limb with half axes, smooth in between; ends are half ellipsoids."""
    along = np.array(limb.along)
    stations = np.linspace(along[0], along[-1], STATIONS)
    across, deep = (PchipInterpolator(along, half)(stations) for half in (limb.across, limb.deep))
    angle = np.linspace(0.5 * np.pi, 0.0, CAP_STATIONS, endpoint=False)
    narrow, reach = np.maximum(np.cos(angle), 1e-3), 0.5 * np.sin(angle)
    z = np.concatenate([stations[0] - deep[0] * reach, stations, stations[-1] + deep[-1] * reach[::-1]])
    halves = [np.concatenate([half[0] * narrow, half, half[-1] * narrow[::-1]]) for half in (across, deep)]
    return z, halves[0], halves[1]


def _skin(solid: _LimbSurface, scenery: Scenery, level: float, random: np.random.Generator) -> Picture:
    """Spots of several sizes about a mean grey level, the same on both sides of the seam."""
    width, height = (int(np.ceil(v)) + 2 for v in solid.skin.max(axis=0))
    spots = np.zeros((height, width - 2), np.float32)
    for size, weight in GRAINS:
        sigma = size * scenery.grain_m * SKIN_PX_PER_M / 2.5
        field = random.standard_normal(spots.shape).astype(np.float32)
        wrapped = cv2.GaussianBlur(np.hstack([field, field, field]), (0, 0), sigma)[:, width - 2 : 2 * (width - 2)]
        spots += weight * wrapped / wrapped.std()
    spots = np.hstack([spots, spots[:, :2]])
    return np.asarray(np.clip(level + scenery.contrast * spots / spots.std(), 5, 250), np.float32)


def _background(width: int, height: int, scenery: Scenery, random: np.random.Generator) -> Picture:
    """A wall with soft shapes; unless it is dark, in parts as bright as skin."""
    shapes = cv2.GaussianBlur(random.standard_normal((height, width)).astype(np.float32), (0, 0), 12.0)
    return np.asarray(scenery.wall + scenery.wall_relief * shapes / shapes.std(), np.float32).clip(0, 255)
