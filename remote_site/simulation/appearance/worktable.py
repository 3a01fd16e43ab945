"""The table: a wooden top with what lies flat on it, steel legs; and the target paper, under the same baked light."""

import math
from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from common.geometry import Array
from remote_site.simulation.appearance import materials, prints
from remote_site.simulation.appearance.light import baked, facing
from remote_site.simulation.appearance.materials import Picture
from remote_site.simulation.appearance.surfaces import PaintedSurface, box_faces, surface

TOP_PX_M, LIGHT_PX_M, EDGE_PX_M = 1300.0, 60.0, 500.0
CLOTH_M = (0.24, 0.36)


def painted_table(
    rng: np.random.Generator, centre: Array, size: tuple[float, float, float], boxes: Sequence[Array], lamp: Array
) -> Iterator[PaintedSurface]:
    """All sides of the table's top, `centre` being the middle of its upper side, with the shadows of `boxes`."""
    half = np.array([size[0] / 2, size[1] / 2, 0.0])
    faces = box_faces(centre - half - (0.0, 0.0, size[2]), centre + half)
    top = faces.pop((2, 1))
    for rectangle in faces.values():
        light = np.full((2, 2), facing(rectangle.normal), dtype=np.float32)
        yield surface(rectangle, materials.wood(rng, rectangle.shape(EDGE_PX_M), EDGE_PX_M), light, of_table=True)
    light = baked(top, top.shape(LIGHT_PX_M), boxes, lamp, centre)
    yield surface(top, _top(rng, top.shape(TOP_PX_M)), light, of_table=True)


def _top(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    """Oak, a cloth, a rule, a note, a cable, rings of cups: all flat, nothing that the arm could run into."""
    picture = materials.wood(rng, shape, TOP_PX_M)
    _rings(rng, picture)
    cloth = materials.printed_cloth(rng, (round(CLOTH_M[0] * TOP_PX_M), round(CLOTH_M[1] * TOP_PX_M)), TOP_PX_M)
    _lay(picture, cloth, (0.74 * shape[0], 0.68 * shape[1]), 6.0, 5)
    rule = prints.steel_rule((round(0.028 * TOP_PX_M), round(0.30 * TOP_PX_M)))
    _lay(picture, rule, (0.62 * shape[0], 0.16 * shape[1]), -64.0, 2)
    note = prints.notice(rng, (round(0.148 * TOP_PX_M), round(0.105 * TOP_PX_M)), "Trial 12")
    _lay(picture, note, (0.78 * shape[0], 0.36 * shape[1]), 11.0, 2)
    path = [(0.30, 1.02), (0.36, 0.93), (0.22, 0.88), (0.12, 0.93), (0.06, 0.86), (-0.05, 0.88)]
    prints.cable(picture, [(v * shape[0], u * shape[1]) for v, u in path], 0.007 * TOP_PX_M, (0.13, 0.13, 0.14))
    return picture


def _rings(rng: np.random.Generator, picture: Picture) -> None:
    stain = np.ones(picture.shape[:2], dtype=np.float32)
    for _ in range(3):
        centre = [int(rng.uniform(0.1, 0.9) * size) for size in picture.shape[1::-1]]
        start, end = sorted(float(angle) for angle in rng.uniform(0, 500, 2))
        cv2.ellipse(stain, centre, (52, 50), 0.0, start, end, 0.86, 4, cv2.LINE_AA)
    picture[:] = materials.shaded(picture, np.asarray(cv2.GaussianBlur(stain, (0, 0), 1.5), dtype=np.float32))


def _lay(ground: Picture, sheet: Picture, centre: tuple[float, float], turned_deg: float, lift_px: int) -> None:
    """Lay a sheet on the ground, its centre at (row, column), turned counterclockwise."""
    height, width = sheet.shape[:2]
    half = math.ceil(math.hypot(height, width) / 2) + 4 * lift_px
    rows, columns = (slice(max(0, round(at) - half), round(at) + half) for at in centre)
    area = ground[rows, columns]
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), turned_deg, 1.0)
    turn[:, 2] += (centre[1] - columns.start - width / 2, centre[0] - rows.start - height / 2)
    size = area.shape[1::-1]
    moved = cv2.warpAffine(sheet, turn, size)
    mask = cv2.warpAffine(np.ones((height, width), dtype=np.float32), turn, size)
    shadow = cv2.GaussianBlur(np.roll(mask, (lift_px, -lift_px), (0, 1)), (0, 0), 0.8 * lift_px)
    area *= 1.0 - prints.SHADOW * shadow[:, :, None]
    area += mask[:, :, None] * (moved - area)
