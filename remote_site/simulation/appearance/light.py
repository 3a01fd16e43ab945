"""Light and shadow on rectangles among boxes, to be baked into textures.

A lamp is a set of points, the sky a set of directions. From each, the boxes are projected onto the rectangle and drawn
as hard shadows; their mean is the soft one (sampled irradiance: Cohen and Wallace, Radiosity and Realistic Image
Synthesis, 1993).
"""

from collections.abc import Iterable

import cv2
import numpy as np

from common.geometry import Array
from remote_site.simulation.appearance.materials import Field
from remote_site.simulation.appearance.surfaces import Rectangle

AMBIENT, KEY = 0.62, 0.50
BOUNCED = 0.35  # of the ambient light: reaches every corner
LAMP_SAMPLES, SKY_SAMPLES = (4, 4), (3, 12)
LAMP_HALF_M = (0.5, 0.7)
CORNER_M = 0.30
CORNER_DARKENING = 0.16
TO_LAMP = np.array([0.5, -0.45, 0.85]) / np.linalg.norm([0.5, -0.45, 0.85])


def lamp_points(above: Array, ceiling_z: float) -> Array:
    """Sample points (N, 3) of a ceiling panel that lights the point `above` from TO_LAMP."""
    centre = above + TO_LAMP * (ceiling_z - above[2]) / TO_LAMP[2]
    steps = [(np.arange(n) + 0.5) / n * 2.0 - 1.0 for n in LAMP_SAMPLES]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
    return np.column_stack([grid * LAMP_HALF_M + centre[:2], np.full(len(grid), centre[2])])


def baked(rectangle: Rectangle, shape: tuple[int, int], boxes: Iterable[Array], lamp: Array, aim: Array) -> Field:
    """The light (H, W) on a rectangle among boxes (each 8 x 3 corners): 1.1 where the lamp shines straight on `aim`."""
    corners = np.array(list(boxes)).reshape(-1, 8, 3)
    ambient = BOUNCED + (1.0 - BOUNCED) * _sky(rectangle, shape, corners)
    return np.asarray(AMBIENT * ambient + KEY * _lamp(rectangle, shape, corners, lamp, aim), dtype=np.float32)


def facing(normal: Array) -> float:
    """The light on a small face that nothing shades."""
    return AMBIENT * (0.75 + 0.25 * float(normal[2])) + KEY * max(0.0, float(normal @ TO_LAMP))


def _lamp(rectangle: Rectangle, shape: tuple[int, int], boxes: Array, lamp: Array, aim: Array) -> Field:
    total = np.zeros(shape, dtype=np.float32)
    points, normal = rectangle.points(shape), rectangle.normal
    for source in lamp:
        way = source - points
        distance2 = np.einsum("hwi,hwi->hw", way, way)
        cosine = np.maximum(way @ normal, 0.0) * way[:, :, 2] / distance2  # of the surface and of the lamp, facing down
        reach2 = float(np.sum((source - aim) ** 2))
        shadows = _from_point(rectangle, boxes, normal, source)
        total += cosine * reach2 / distance2 * _unshaded(rectangle, shape, shadows)
    return _smoothed(total / len(lamp))


def _sky(rectangle: Rectangle, shape: tuple[int, int], boxes: Array) -> Field:
    rings, spokes = SKY_SAMPLES
    total = np.zeros(shape, dtype=np.float32)
    right = rectangle.right / np.linalg.norm(rectangle.right)
    normal = rectangle.normal
    up = np.cross(normal, right)
    for ring in range(rings):
        sine = np.sqrt((ring + 0.5) / rings)  # equal steps of sine squared: weighted by the cosine
        for spoke in range(spokes):
            angle = 2.0 * np.pi * (spoke + 0.5 * (ring % 2)) / spokes
            along = sine * (np.cos(angle) * right + np.sin(angle) * up)
            direction = along + np.sqrt(1.0 - sine**2) * normal
            total += _unshaded(rectangle, shape, _from_direction(rectangle, boxes, normal, direction))
    return _smoothed(total / (rings * spokes))


def _from_point(rectangle: Rectangle, boxes: Array, normal: Array, source: Array) -> Array:
    reach = float((source - rectangle.corner) @ normal)
    heights = np.maximum((boxes - rectangle.corner) @ normal, 0.0)
    between = (heights.max(axis=1) > 1e-6) & (heights.max(axis=1) < 0.95 * reach)
    boxes, heights = boxes[between], heights[between]
    return np.asarray(source + (boxes - source) * (reach / (reach - heights))[:, :, None], dtype=float)


def _from_direction(rectangle: Rectangle, boxes: Array, normal: Array, direction: Array) -> Array:
    heights = np.maximum((boxes - rectangle.corner) @ normal, 0.0)
    above = heights.max(axis=1) > 1e-6
    boxes, heights = boxes[above], heights[above]
    return np.asarray(boxes - direction * (heights / float(direction @ normal))[:, :, None], dtype=float)


def _unshaded(rectangle: Rectangle, shape: tuple[int, int], shadows: Array) -> Field:
    """1 where none of the shadows, each of 8 points (n, 8, 3), falls on the rectangle, else 0."""
    seen: Field = np.ones(shape, dtype=np.float32)
    (height_m, width_m), (height, width) = rectangle.size_m, shape
    to_px = np.column_stack([rectangle.right * width / width_m**2, -rectangle.up * height / height_m**2])
    outlines = np.clip((shadows - rectangle.corner) @ to_px + (0.0, height), -9999, 9999)
    hits = (outlines.max(axis=1) > 0).all(axis=1) & (outlines.min(axis=1) < (width, height)).all(axis=1)
    for outline in np.rint(outlines[hits] * 16 - 8).astype(np.int32):
        cv2.fillConvexPoly(seen, cv2.convexHull(outline), 0.0, shift=4)
    return seen


def _smoothed(light: Array) -> Field:
    """Smooth away the steps between the hard shadows."""
    return np.asarray(cv2.GaussianBlur(light.astype(np.float32), (0, 0), 1.2), dtype=np.float32)
