"""The arm's surface as one camera sees it: a kernel that blends balls, and light on what it finds."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.simulation.room.surface import Coat

Field = NDArray[np.float32]

BLEND = 0.35  # of a ball's radius: how far below the foremost ball another still counts
FAR_M = 1e9
COARSE = 4
HOLLOW_WIDE_M = 0.013
HOLLOW_M = 0.011
DARKEST_HOLLOW = 0.20
SUMS = 7  # weight, normal (3), reflectance (3)
SPILL_PX = 3
GLOSS, GLOSS_POWER = 0.035, 24
GAMMA = 2.2
STEPS = 1024


@dataclass(frozen=True, slots=True)
class SeenBalls:
    """M balls in one camera: centres (M, 2) and radii (M,) in px, distances and radii (M,) in m along the line of
    sight, and their backs (M, 3) in the camera's frame."""

    centres_px: Array
    radii_px: Array
    depths: Array
    radii: Array
    backs: Array


@dataclass(frozen=True, slots=True)
class Lamps:
    """Light in the camera's frame: directions (L, 3) to the lamps, their colours (L, 3), blue first; `ambient` (3,)
    from all sides, more of it along `up` (3,)."""

    directions: Array
    colours: Array
    ambient: Array
    up: Array


class Shader:
    """Shades what one camera sees; keeps its working memory, since the system is slow to give so much each time."""

    def __init__(self, lamps: Lamps, size: tuple[int, int]) -> None:
        self._lamps = lamps
        self._nearest = np.empty(size[0] * size[1], np.float32)
        self._sums = np.empty(size[0] * size[1] * SUMS, np.float32)

    def shade(self, balls: SeenBalls, coat: Coat, cover: Image) -> Image:
        """Shade the balls for the camera: BGR times cover, and cover, (H, W, 4) for a cover (H, W) of 0 to 255.

        Covered pixels just beyond the balls look like their neighbours.
        """
        lamps = self._lamps
        nearest = self._nearest[: cover.size].reshape(cover.shape)
        nearest.fill(FAR_M)
        sums = self._sums[: cover.size * SUMS].reshape(*cover.shape, SUMS)
        sums.fill(0.0)
        _foremost(balls.centres_px, balls.radii_px, balls.depths, balls.radii, nearest)
        _blend(
            balls.centres_px, balls.radii_px, balls.depths, balls.radii, balls.backs,
            coat.palm, coat.back, coat.turn, nearest, sums,
        )  # fmt: skip
        layer = np.zeros((*cover.shape, 4), np.uint8)
        open_to = _openness(nearest, HOLLOW_WIDE_M * float(np.mean(balls.radii_px / balls.radii)))
        _light(sums, open_to, cover, lamps.directions, lamps.colours, lamps.ambient, lamps.up, _LEVELS, layer)
        return layer


def lay_on(picture: Image, layer: Image) -> None:
    """Draw a layer (H, W, 4) of BGR times cover, and cover, on a BGR picture (H, W, 3)."""
    _lay_on(picture, layer)


def _openness(nearest: Field, sigma_px: float) -> Field:
    """Compute how much light from all sides reaches each pixel (H, W): less where its surroundings are nearer."""
    height, width = nearest.shape
    size = max(1, width // COARSE), max(1, height // COARSE)
    few = cv2.resize(nearest, size, interpolation=cv2.INTER_NEAREST)
    seen = np.asarray(few < FAR_M, np.float32)
    weighted = cv2.GaussianBlur(few * seen, (0, 0), sigma_px / COARSE)
    around = weighted / np.maximum(cv2.GaussianBlur(seen, (0, 0), sigma_px / COARSE), np.float32(1e-3))
    fine = cv2.resize(around, (width, height), interpolation=cv2.INTER_LINEAR)
    deeper = np.clip((nearest - fine) * np.float32(1.0 / HOLLOW_M), 0.0, 1.0)
    return np.asarray(1.0 - np.float32(1.0 - DARKEST_HOLLOW) * deeper, dtype=np.float32)


@compiled
def _foremost(centres_px: Array, radii_px: Array, depths: Array, radii: Array, nearest: Field) -> None:
    height, width = nearest.shape
    for k in range(len(depths)):
        u, v, reach = centres_px[k, 0], centres_px[k, 1], radii_px[k]
        steep = radii[k] / reach
        for y in range(max(int(np.ceil(v - reach)), 0), min(int(v + reach), height - 1) + 1):
            room = reach * reach - (y - v) ** 2
            half = np.sqrt(max(room, 0.0))
            for x in range(max(int(np.ceil(u - half)), 0), min(int(u + half), width - 1) + 1):
                depth = np.float32(depths[k] - steep * np.sqrt(max(room - (x - u) ** 2, 0.0)))
                nearest[y, x] = min(nearest[y, x], depth)


@compiled
def _blend(
    centres_px: Array,
    radii_px: Array,
    depths: Array,
    radii: Array,
    backs: Array,
    palm: Array,
    back: Array,
    turn: Array,
    nearest: Field,
    out: Field,
) -> None:
    """Sums of weight, normal and reflectance over all balls near the surface."""
    height, width = nearest.shape
    for k in range(len(depths)):
        u, v, reach = centres_px[k, 0], centres_px[k, 1], radii_px[k]
        shrink, thin, highest = 1.0 / reach, 1.0 / (BLEND * radii[k]), 1.0 - depths[k] / (BLEND * radii[k])
        for y in range(max(int(np.ceil(v - reach)), 0), min(int(v + reach), height - 1) + 1):
            half = np.sqrt(max(reach * reach - (y - v) ** 2, 0.0))
            ny = (y - v) * shrink
            for x in range(max(int(np.ceil(u - half)), 0), min(int(u + half), width - 1) + 1):
                nx = (x - u) * shrink
                nz = np.sqrt(max(1.0 - nx * nx - ny * ny, 0.0))
                above = highest + nearest[y, x] * thin + nz * (1.0 / BLEND)
                if above <= 0.0:
                    continue
                weight = above * above * (0.05 + nz)
                facing = nx * backs[k, 0] + ny * backs[k, 1] - nz * backs[k, 2]
                side = weight * min(max(turn[k, 0] + turn[k, 1] * facing, 0.0), 1.0)
                sums = out[y, x]
                sums[0] += weight
                sums[1] += weight * nx
                sums[2] += weight * ny
                sums[3] -= weight * nz
                for c in range(3):
                    sums[4 + c] += weight * palm[k, c] + side * (back[k, c] - palm[k, c])


@compiled
def _light(
    sums: Field,
    openness: Field,
    cover: Image,
    directions: Array,
    colours: Array,
    ambient: Array,
    up: Array,
    levels: Field,
    out: Image,
) -> None:
    height, width = cover.shape
    found, light, gloss = np.empty(SUMS, np.float32), np.empty(3), np.empty(3)
    for y in range(height):
        for x in range(width):
            if cover[y, x] == 0:
                continue
            found[:] = sums[y, x]
            if found[0] == 0.0:
                for row in range(max(y - SPILL_PX, 0), min(y + SPILL_PX + 1, height)):
                    for column in range(max(x - SPILL_PX, 0), min(x + SPILL_PX + 1, width)):
                        found += sums[row, column]
            if found[0] == 0.0:
                found[0], found[3] = 1.0, -1.0
            length = np.sqrt(found[1] ** 2 + found[2] ** 2 + found[3] ** 2) + 1e-9
            nx, ny, nz = found[1] / length, found[2] / length, found[3] / length
            sky = 0.55 + 0.45 * (nx * up[0] + ny * up[1] + nz * up[2])
            light[:] = sky * ambient
            # What turns away from the camera lies deeper than its surroundings without being hollow.
            reached = 1.0 - (1.0 - openness[y, x]) * nz * nz
            gloss[:] = 0.0
            for lamp in range(len(directions)):
                lx, ly, lz = directions[lamp, 0], directions[lamp, 1], directions[lamp, 2]
                falling = nx * lx + ny * ly + nz * lz
                # Half way between lamp and camera, which looks along z.
                half = np.sqrt(lx * lx + ly * ly + (lz - 1.0) ** 2)
                mirrored = max((nx * lx + ny * ly + nz * (lz - 1.0)) / half, 0.0) ** GLOSS_POWER
                for c in range(3):
                    # Light enters skin and comes out again where none falls, red farthest.
                    wrap = 0.05 + 0.08 * c
                    light[c] += colours[lamp, c] * max((falling + wrap) / (1.0 + wrap), 0.0)
                    gloss[c] += colours[lamp, c] * mirrored
            for c in range(3):
                sent = reached * (light[c] * found[4 + c] / found[0] + GLOSS * gloss[c])
                level = levels[min(int(sent * STEPS), len(levels) - 1)]
                out[y, x, c] = np.uint8(level * cover[y, x] + 0.5)
            out[y, x, 3] = cover[y, x]


@compiled
def _lay_on(picture: Image, layer: Image) -> None:
    height, width = layer.shape[:2]
    for y in range(height):
        for x in range(width):
            cover = int(layer[y, x, 3])
            if cover == 0:
                continue
            for c in range(3):
                behind = (int(picture[y, x, c]) * (255 - cover) + 127) // 255
                picture[y, x, c] = min(behind + int(layer[y, x, c]), 255)


_LEVELS = np.asarray((np.arange(STEPS + 1) / STEPS) ** (1.0 / GAMMA), np.float32)
