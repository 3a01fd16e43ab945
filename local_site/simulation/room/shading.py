"""The arm's surface as one camera sees it: a kernel that blends balls, and light on what it finds."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.simulation.room.surface import Coat

Field = NDArray[np.float32]

BLEND = 0.35  # of a ball's radius: how far below the foremost ball another still counts
FAR_M = 1e9
HOLLOW_PX = 7.0
HOLLOW_M = 0.016
DARKEST_HOLLOW = 0.45


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


def shade(balls: SeenBalls, coat: Coat, lamps: Lamps, width: int, height: int) -> tuple[Field, Field]:
    """The light (H, W, 3) that the surface sends to the camera, and where it is seen (H, W), 0 or 1."""
    nearest = np.full((height, width), FAR_M, np.float32)
    _foremost(balls.centres_px, balls.radii_px, balls.depths, balls.radii, nearest)
    blended = np.zeros((height, width, 7), np.float32)
    _blend(
        balls.centres_px, balls.radii_px, balls.depths, balls.radii, balls.backs,
        coat.palm, coat.back, coat.turn, nearest, blended,
    )  # fmt: skip
    seen = (nearest < FAR_M).astype(np.float32)
    light = np.zeros((height, width, 3), np.float32)
    _light(blended, _hollows(nearest, seen), lamps.directions, lamps.colours, lamps.ambient, lamps.up, light)
    return light, seen


def _hollows(nearest: Field, seen: Field) -> Field:
    """How much light reaches each pixel (H, W): less where its surroundings stand out towards the camera."""
    weighted = cv2.GaussianBlur(np.where(seen > 0.0, nearest, np.float32(0.0)), (0, 0), HOLLOW_PX)
    around = weighted / np.maximum(cv2.GaussianBlur(seen, (0, 0), HOLLOW_PX), np.float32(1e-3))
    deeper = np.clip((nearest - around) / np.float32(HOLLOW_M), 0.0, 1.0)
    return np.asarray(1.0 - (1.0 - DARKEST_HOLLOW) * deeper, dtype=np.float32)


@compiled
def _foremost(centres_px: Array, radii_px: Array, depths: Array, radii: Array, nearest: Field) -> None:
    height, width = nearest.shape
    for k in range(len(depths)):
        u, v, reach = centres_px[k, 0], centres_px[k, 1], radii_px[k]
        for y in range(max(int(np.ceil(v - reach)), 0), min(int(v + reach), height - 1) + 1):
            half = np.sqrt(max(reach * reach - (y - v) ** 2, 0.0))
            for x in range(max(int(np.ceil(u - half)), 0), min(int(u + half), width - 1) + 1):
                inside = 1.0 - ((x - u) ** 2 + (y - v) ** 2) / (reach * reach)
                depth = depths[k] - radii[k] * np.sqrt(max(inside, 0.0))
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
    """Sums of weight, normal (3) and reflectance (3) of all balls near the surface."""
    height, width = nearest.shape
    for k in range(len(depths)):
        u, v, reach = centres_px[k, 0], centres_px[k, 1], radii_px[k]
        thick = BLEND * radii[k]
        for y in range(max(int(np.ceil(v - reach)), 0), min(int(v + reach), height - 1) + 1):
            half = np.sqrt(max(reach * reach - (y - v) ** 2, 0.0))
            for x in range(max(int(np.ceil(u - half)), 0), min(int(u + half), width - 1) + 1):
                nx, ny = (x - u) / reach, (y - v) / reach
                nz = np.sqrt(max(1.0 - nx * nx - ny * ny, 0.0))
                below = (depths[k] - radii[k] * nz - nearest[y, x]) / thick
                if below >= 1.0:
                    continue
                weight = (1.0 - below) ** 2 * (0.05 + nz)
                facing = nx * backs[k, 0] + ny * backs[k, 1] - nz * backs[k, 2]
                side = min(max(turn[k, 0] + turn[k, 1] * facing, 0.0), 1.0)
                out[y, x, 0] += weight
                out[y, x, 1] += weight * nx
                out[y, x, 2] += weight * ny
                out[y, x, 3] -= weight * nz
                for c in range(3):
                    out[y, x, 4 + c] += weight * (palm[k, c] + side * (back[k, c] - palm[k, c]))


@compiled
def _light(
    blended: Field, open_to_light: Field, directions: Array, colours: Array, ambient: Array, up: Array, out: Field
) -> None:
    height, width = open_to_light.shape
    for y in range(height):
        for x in range(width):
            weight = blended[y, x, 0]
            if weight <= 0.0:
                continue
            nx, ny, nz = blended[y, x, 1], blended[y, x, 2], blended[y, x, 3]
            length = np.sqrt(nx * nx + ny * ny + nz * nz) + 1e-9
            nx, ny, nz = nx / length, ny / length, nz / length
            sky = 0.7 + 0.3 * (nx * up[0] + ny * up[1] + nz * up[2])
            for c in range(3):
                # Light enters skin and comes out again where none falls, red farthest.
                wrap = 0.15 + 0.10 * c
                total = ambient[c] * sky * open_to_light[y, x]
                for lamp in range(len(directions)):
                    falling = nx * directions[lamp, 0] + ny * directions[lamp, 1] + nz * directions[lamp, 2]
                    total += colours[lamp, c] * max((falling + wrap) / (1.0 + wrap), 0.0) * open_to_light[y, x]
                out[y, x, c] = total * blended[y, x, 4 + c] / weight
            for lamp in range(len(directions)):
                # The camera looks along z; a lamp's mirror image shows as a faint gloss.
                hx, hy, hz = directions[lamp, 0], directions[lamp, 1], directions[lamp, 2] - 1.0
                half = np.sqrt(hx * hx + hy * hy + hz * hz)
                gloss = max((nx * hx + ny * hy + nz * hz) / half, 0.0) ** 24
                for c in range(3):
                    out[y, x, c] += 0.035 * colours[lamp, c] * gloss * open_to_light[y, x]
