"""Furniture of the room: a rack, a workbench, cartons, cabinets; upright boxes, each face with a picture."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from common.geometry import Array
from remote_site.simulation.appearance import materials, prints
from remote_site.simulation.appearance.light import facing
from remote_site.simulation.appearance.materials import Colour, Picture
from remote_site.simulation.appearance.surfaces import Rectangle, box_corners, box_faces

Point = tuple[float, float, float]
Paint = Callable[[np.random.Generator, tuple[int, int]], Picture]

PX_M = 300.0
FACES = ((0, 1), (0, -1), (1, 1), (1, -1), (2, 1))  # axis and side; nobody sees a box from below
GREY: Colour = (0.40, 0.42, 0.44)
DARK: Colour = (0.20, 0.21, 0.23)
BEIGE: Colour = (0.66, 0.65, 0.60)
BIRCH: Colour = (0.68, 0.61, 0.52)
GREEN: Colour = (0.26, 0.37, 0.30)


@dataclass(frozen=True, slots=True)
class FurnitureBox:
    """An upright box, from its lowest to its highest corner (m), the floor at zero; `front` is its side to the room."""

    low: Point
    high: Point
    body: Paint
    front: Paint | None = None
    facing: tuple[int, int] = (0, 1)

    def corners(self, floor_z: float) -> Array:
        """The eight corners (8, 3) in the base frame."""
        floor = np.array([0.0, 0.0, floor_z])
        return box_corners(floor + self.low, floor + self.high)

    def faces(self, rng: np.random.Generator, floor_z: float) -> Iterator[tuple[Rectangle, Picture]]:
        """Every face that can be seen, and its picture with light in it."""
        floor = np.array([0.0, 0.0, floor_z])
        rectangles = box_faces(floor + self.low, floor + self.high)
        for face in FACES:
            rectangle = rectangles[face]
            shape = rectangle.shape(PX_M)
            paint = self.front if self.front and face == self.facing else self.body
            picture = paint(rng, shape)
            rise = np.linspace(1.0, 0.80 if self.low[2] < 0.02 else 0.92, shape[0], dtype=np.float32)
            fall = rise if face[0] < 2 else np.ones(shape[0], dtype=np.float32)
            light = np.float32(facing(rectangle.normal)) * np.repeat(fall[:, None], shape[1], axis=1)
            yield rectangle, materials.shaded(picture, light)


def furniture() -> list[FurnitureBox]:
    """Everything in the room but the cell itself."""
    return [*_rack(), *_bench(), *_on_the_floor()]


def _painted(colour: Colour) -> Paint:
    return lambda rng, shape: materials.painted_metal(rng, shape, colour)


def _profile(colour: Colour) -> Paint:
    return lambda _, shape: materials.plain(shape, colour)


def _labelled(words: str, rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    carton = materials.cardboard(rng, shape)
    height, width = shape
    tape = slice(round(0.45 * width), round(0.57 * width))
    carton[: round(0.3 * height), tape] = carton[: round(0.3 * height), tape] * 0.5 + 0.30
    sheet = prints.label(rng, (max(12, round(0.34 * height)), max(24, round(0.40 * width))), words)
    prints.paste(carton, sheet, round(0.42 * height), round(rng.uniform(0.08, 0.5) * width), 1)
    return carton


def _carton(low: Point, high: Point, words: str, facing: tuple[int, int] = (0, 1)) -> FurnitureBox:
    return FurnitureBox(low, high, materials.cardboard, partial(_labelled, words), facing)


def _drawers(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    front = materials.painted_metal(rng, shape, BEIGE)
    height, width = shape
    for k in range(1, 4):
        front[round(k * height / 4) - 1 : round(k * height / 4) + 1] *= 0.35
    for k in range(4):
        middle = round((k + 0.45) * height / 4)
        front[middle : middle + 4, round(0.36 * width) : round(0.64 * width)] = DARK
    return front


def _controller(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    front = materials.painted_metal(rng, shape, GREY)
    height, width = shape
    for row in range(round(0.55 * height), round(0.90 * height), 5):
        front[row : row + 2, round(0.12 * width) : round(0.62 * width)] *= 0.3
    front[round(0.08 * height) : round(0.40 * height), round(0.1 * width) : round(0.9 * width)] = (0.55, 0.56, 0.56)
    prints.text(front, "C500C", (round(0.22 * height), round(0.16 * width)), 0.08 * height)
    for k, colour in enumerate(((0.30, 0.62, 0.34), (0.62, 0.60, 0.42), DARK, DARK)):
        left = round((0.18 + 0.16 * k) * width)
        front[round(0.28 * height) : round(0.34 * height), left : left + 7] = colour
    prints.paste(front, prints.label(rng, (22, 36), "400 V"), round(0.58 * height), round(0.68 * width), 1)
    return front


def _instrument(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    front = materials.painted_metal(rng, shape, (0.58, 0.58, 0.55))
    height, width = shape
    screen = front[round(0.14 * height) : round(0.80 * height), round(0.06 * width) : round(0.56 * width)]
    screen[:] = (0.05, 0.10, 0.09)
    screen[::7] += 0.05
    screen[:, ::7] += 0.05
    columns = np.arange(screen.shape[1])
    wave = ((0.5 + 0.3 * np.sin(columns * 0.22)) * (screen.shape[0] - 1)).astype(int)
    screen[wave, columns] = (0.55, 0.85, 0.60)
    for row in np.linspace(0.25, 0.75, 3):
        for column in np.linspace(0.64, 0.93, 4):
            middle = (round(row * height), round(column * width))
            front[middle[0] - 2 : middle[0] + 3, middle[1] - 3 : middle[1] + 3] = DARK
    return front


def _bins(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    front = materials.plain(shape, DARK)
    height, width = shape
    columns, rows = max(2, round(width / 38)), max(1, round(height / 30))
    for row in range(rows):
        for column in range(columns):
            top, left = round(row * height / rows), round(column * width / columns)
            bin_ = front[top + 2 : top + height // rows - 1, left + 1 : left + width // columns - 1]
            bin_[:] = materials.rgb((GREEN, GREY, (0.34, 0.33, 0.31))[int(rng.integers(3))]) * rng.uniform(0.85, 1.1)
            bin_[: bin_.shape[0] // 3] *= 0.35
            tag = bin_[bin_.shape[0] // 2 : -5, 6:-6]
            tag[:] = prints.PAPER
            prints.paragraph(rng, tag, 3)
    return front


def _rack() -> Iterator[FurnitureBox]:
    near, far, left, right, top = -1.24, -1.59, 1.00, 2.12, 1.92
    for x in (near, far + 0.03):
        for y in (left, right - 0.03):
            yield FurnitureBox((x - 0.03, y, 0.0), (x, y + 0.03, top), _profile(GREY))
    for z in (0.12, 0.58, 1.04, 1.48, top - 0.03):
        yield FurnitureBox((far, left, z), (near, right, z + 0.03), _profile(GREY))
    yield _carton((-1.55, 1.06, 0.15), (-1.27, 1.50, 0.47), "MOTORS 24V")
    yield _carton((-1.55, 1.56, 0.15), (-1.30, 2.05, 0.40), "SPARE PARTS")
    yield FurnitureBox((-1.55, 1.06, 0.61), (-1.28, 2.06, 0.86), _painted(DARK), _bins)
    yield FurnitureBox((-1.56, 1.05, 1.07), (-1.28, 1.62, 1.39), _painted(DARK), prints.binders)
    yield _carton((-1.55, 1.70, 1.07), (-1.26, 2.06, 1.33), "CABLES")
    yield _carton((-1.55, 1.07, 1.51), (-1.25, 1.40, 1.74), "GRIPPER")
    yield FurnitureBox((-1.55, 1.48, 1.51), (-1.30, 2.04, 1.82), _painted(DARK), prints.binders)


def _bench() -> Iterator[FurnitureBox]:
    towards, front, back, left, right, top = (1, -1), 1.55, 2.19, -1.0, 1.7, 0.80
    yield FurnitureBox((left, front, top - 0.04), (right, back, top), _painted(BIRCH))
    for x in (left + 0.02, right - 0.07):
        yield FurnitureBox((x, front + 0.03, 0.0), (x + 0.05, front + 0.08, top - 0.04), _profile(GREY))
    yield FurnitureBox((-0.75, front + 0.05, 0.05), (-0.30, back, top - 0.06), _painted(BEIGE), _drawers, towards)
    yield FurnitureBox((0.95, front + 0.05, 0.05), (1.40, back, top - 0.06), _painted(BEIGE), _drawers, towards)
    yield _carton((0.05, 1.70, 0.0), (0.60, 2.12, 0.38), "ROBOT ARM", towards)
    yield FurnitureBox((-0.92, 1.78, top), (-0.50, 2.12, top + 0.20), _painted(BEIGE), _instrument, towards)
    yield FurnitureBox((-0.90, 1.80, top + 0.20), (-0.54, 2.10, top + 0.32), _painted(GREY), _instrument, towards)
    yield FurnitureBox((-0.30, 1.92, top), (0.22, 2.16, top + 0.27), _painted(DARK), _bins, towards)
    yield _carton((0.40, 1.84, top), (0.72, 2.12, top + 0.18), "OPTICS", towards)
    yield FurnitureBox((0.85, 1.88, top), (1.50, 2.16, top + 0.31), _painted(DARK), prints.binders, towards)


def _on_the_floor() -> Iterator[FurnitureBox]:
    yield FurnitureBox((-1.58, -1.25, 0.04), (-1.10, -0.72, 0.66), _painted(GREY), _controller)
    yield _carton((-1.55, -2.05, 0.0), (-1.13, -1.50, 0.42), "FRAGILE")
    yield _carton((-1.52, -1.95, 0.42), (-1.20, -1.58, 0.66), "A465 TOOLS")
    yield FurnitureBox((-1.52, -0.45, 0.0), (-1.27, -0.20, 0.36), _painted(GREEN))
    yield _carton((-1.55, 0.20, 0.0), (-1.22, 0.66, 0.30), "CAMERAS")
