"""Floor and walls of the room with what is painted, mounted and left on them, under baked light."""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from common.geometry import Array
from remote_site.simulation.appearance import materials, prints
from remote_site.simulation.appearance.light import CORNER_DARKENING, CORNER_M, baked
from remote_site.simulation.appearance.materials import Field, Picture
from remote_site.simulation.appearance.surfaces import PaintedSurface, Rectangle, surface

LOW, HIGH = (-1.6, -3.0), (3.2, 2.2)
HEIGHT_M = 3.0
FLOOR_PX_M, WALL_PX_M, PLAIN_PX_M, LIGHT_PX_M = 280.0, 330.0, 90.0, 30.0
DADO_M = 1.02


def painted_room(
    rng: np.random.Generator, floor_z: float, boxes: Sequence[Array], lamp: Array, aim: Array
) -> Iterator[PaintedSurface]:
    """The floor and the four walls with the shadows of `boxes` (each 8 x 3 corners)."""
    painters = {"floor": _floor, "back": _back_wall, "side": _side_wall, "front": _plain_wall, "near": _plain_wall}
    for name, rectangle in _rectangles(floor_z).items():
        px_m = FLOOR_PX_M if name == "floor" else WALL_PX_M if name in ("back", "side") else PLAIN_PX_M
        picture = painters[name](rng, rectangle.shape(px_m), px_m)
        light = baked(rectangle, rectangle.shape(LIGHT_PX_M), boxes, lamp, aim) * _corners(rectangle, name == "floor")
        yield surface(rectangle, picture, light, of_table=False)


def _rectangles(floor_z: float) -> dict[str, Rectangle]:
    (x0, y0), (x1, y1) = LOW, HIGH
    x, y, z = np.diag([x1 - x0, y1 - y0, HEIGHT_M])
    return {
        "floor": Rectangle(np.array([x1, y0, floor_z]), y, -x),
        "back": Rectangle(np.array([x0, y0, floor_z]), y, z),
        "side": Rectangle(np.array([x0, y1, floor_z]), x, z),
        "front": Rectangle(np.array([x1, y1, floor_z]), -y, z),
        "near": Rectangle(np.array([x1, y0, floor_z]), -x, z),
    }


def _corners(rectangle: Rectangle, all_round: bool) -> Field:
    """The darkening (H, W) towards the edges at which other surfaces stand on this one."""
    (height_m, width_m), (height, width) = rectangle.size_m, rectangle.shape(LIGHT_PX_M)
    across = (np.arange(width) + 0.5) / width * width_m
    up = (np.arange(height)[::-1] + 0.5) / height * height_m

    def dark(distance: Array) -> Array:
        return np.asarray(1.0 - CORNER_DARKENING * np.exp(-distance / CORNER_M), dtype=float)

    columns = dark(across) * dark(width_m - across)
    rows = dark(up) * (dark(height_m - up) if all_round else 1.0)
    return np.asarray(rows[:, None] * columns[None, :], dtype=np.float32)


def _floor(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    floor = materials.terrazzo(rng, shape, px_m)
    _scuffs(rng, floor)
    top, left, bottom, right = (round(v * px_m) for v in (1.55, 1.95, 3.55, 4.05))  # around the cell
    wide = round(0.05 * px_m)
    for rows, columns in (
        ((top, top + wide), (left, right)),
        ((bottom - wide, bottom), (left, right)),
        ((top, bottom), (left, left + wide)),
        ((top, bottom), (right - wide, right)),
    ):
        band = floor[slice(*rows), slice(*columns)]
        worn = np.clip(0.75 + 0.35 * materials.noise(rng, band.shape[:2], (5.0, 5.0)), 0.0, 1.0)[:, :, None]
        band += worn * (materials.rgb((0.74, 0.73, 0.66)) - band)

    def at(x: float, y: float) -> tuple[float, float]:
        return (HIGH[0] - x, y - LOW[1])

    for shift, bend in ((0.0, 0.0), (0.03, 0.08)):
        path = [at(-1.1, -1.0 + shift), at(-0.8, -0.85 - bend), at(-0.55, -0.4), at(-0.3, -0.25 + bend), at(0.0, shift)]
        prints.cable(floor, [(px_m * row, px_m * column) for row, column in path], 0.014 * px_m, (0.10, 0.10, 0.11))
    turned = [at(-1.2, 1.1), at(-0.9, 0.9), at(-0.7, 1.3), at(-0.3, 1.2), at(0.1, 1.5), at(0.4, 1.7)]
    prints.cable(floor, [(px_m * row, px_m * column) for row, column in turned], 0.010 * px_m, (0.50, 0.50, 0.48))
    return floor


def _scuffs(rng: np.random.Generator, floor: Picture) -> None:
    layer = np.ones(floor.shape[:2], dtype=np.float32)
    for _ in range(90):
        row, column = (int(rng.integers(0, size)) for size in floor.shape[:2])
        end = (column + int(rng.integers(-40, 40)), row + int(rng.integers(-40, 40)))
        cv2.line(layer, (column, row), end, float(rng.uniform(0.8, 0.94)), int(rng.integers(1, 3)), cv2.LINE_AA)
    floor *= layer[:, :, None]


def _plain_wall(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    wall = materials.painted_blocks(rng, shape, px_m)
    dado = shape[0] - round(DADO_M * px_m)
    wall[dado:] *= materials.rgb((0.74, 0.82, 0.78))
    wall[dado : dado + max(1, round(0.02 * px_m))] *= 0.55
    skirting = max(2, round(0.09 * px_m))
    wall[-skirting:] = materials.rgb((0.30, 0.32, 0.33))
    wall[-skirting - 1 : -skirting] *= 1.2
    return wall


def _trunking(rng: np.random.Generator, wall: Picture, px_m: float, sockets: Sequence[float]) -> None:
    height, width = wall.shape[:2]
    size = (round(0.085 * px_m), width - 8)
    strip = materials.tinted(
        np.float32(1.0) + np.float32(0.012) * materials.noise(rng, size, (3.0, 30.0)), (0.84, 0.85, 0.83)
    )
    strip[-2:] *= 0.75
    strip[len(strip) // 4] *= 0.8
    for at in sockets:
        for k in range(3):
            middle = (round((at + 0.07 * k) * px_m), len(strip) // 2 + 2)
            cv2.circle(strip, middle, round(0.022 * px_m), (0.62, 0.63, 0.62), -1, cv2.LINE_AA)
            cv2.circle(strip, middle, round(0.016 * px_m), (0.48, 0.49, 0.49), -1, cv2.LINE_AA)
    prints.paste(wall, strip, height - round((DADO_M + 0.15) * px_m), 4, 3)


def _back_wall(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    wall = _plain_wall(rng, shape, px_m)
    _trunking(rng, wall, px_m, (1.9, 2.55, 3.75))

    def mount(sheet: Picture, y: float, above_floor: float) -> None:
        prints.paste(wall, sheet, shape[0] - round(above_floor * px_m), round((y - LOW[1]) * px_m), 2)

    def size(height_m: float, width_m: float) -> tuple[int, int]:
        return round(height_m * px_m), round(width_m * px_m)

    mount(prints.poster(rng, size(0.84, 0.60), "TELEOPERATION", (0.22, 0.36, 0.32)), -0.52, 2.10)
    mount(prints.notice(rng, size(0.30, 0.21), "SAFETY"), 0.72, 1.62)
    mount(prints.notice(rng, size(0.21, 0.30), "A465 cell"), 0.66, 1.93)
    mount(prints.poster(rng, size(0.70, 0.50), "GRASPING", (0.38, 0.30, 0.34)), -1.30, 2.05)
    drop = [(px_m * (HEIGHT_M - z), px_m * (y - LOW[1])) for z, y in ((1.15, -0.6), (0.8, -0.63), (0.62, -0.75))]
    prints.cable(wall, drop, 0.012 * px_m, (0.12, 0.12, 0.13))
    return wall


def _side_wall(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    wall = _plain_wall(rng, shape, px_m)
    _trunking(rng, wall, px_m, (0.75, 2.1, 3.0))

    def mount(sheet: Picture, x: float, above_floor: float) -> None:
        prints.paste(wall, sheet, shape[0] - round(above_floor * px_m), round((x - LOW[0]) * px_m), 4)

    def size(height_m: float, width_m: float) -> tuple[int, int]:
        return round(height_m * px_m), round(width_m * px_m)

    mount(prints.pegboard(rng, size(0.75, 1.50), px_m), -1.05, 2.00)
    mount(prints.poster(rng, size(0.84, 0.60), "TELEROBOTICS", (0.34, 0.34, 0.38)), 0.72, 2.08)
    mount(prints.notice(rng, size(0.297, 0.21), "Lab rules"), 1.48, 1.75)
    for x in (-0.7, 0.3):
        hang = [(px_m * (HEIGHT_M - z), px_m * (u - LOW[0])) for z, u in ((1.13, x), (0.95, x + 0.05), (0.82, x + 0.2))]
        prints.cable(wall, hang, 0.010 * px_m, (0.14, 0.14, 0.15))
    return wall
