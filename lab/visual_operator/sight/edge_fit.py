"""The exact pose of a thing of known shape: where its colour ends beside the edges that its pose would show.

After the RAPiD tracker (Harris and Stennett 1990): samples along each edge of the outline, each looked for along the
edge's normal, and the pose that brings the edges to them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import cv2
import numpy as np

from common.geometry import Array
from lab.visual_operator.sight.pose_fit import Fitted, moved

STEP_PX = 0.25
REACHES_PX = (24.0, 12.0, 12.0, 7.0, 4.0, 4.0, 4.0)  # of the iterations, how far along its normal an edge is looked for
SPACING_PX, MOST_SAMPLES = 4.0, 12
FROM_CORNER = 0.15  # of an edge; colour is blurred, and rounds the corners
SHORTEST_PX = 4.0
EDGE_SIGMA_PX, CLEAR_PX = 0.4, 4.0
LEAST_SAMPLES = 8
NEXT_CORNERS, HALF, TWO_FACES = (4, 2, 1), 0.5, 2  # of a box, whose corners come in the order of their coordinates
NEAR_PX, ACROSS, LEAST_STEP = 7.0, 4, 8.0
TURN = 1e-5
NO_EDGES = np.empty((0, 2), dtype=int)


class Coloured(Protocol):
    """By how much each pixel of a part of a picture is above a thing's colour (H, W); the part begins at `corner`.

    `projection` (3, 4) is the view's, from the frame in which the pose is wanted.
    """

    @property
    def above(self) -> Array: ...
    @property
    def luma(self) -> Array: ...
    @property
    def corner(self) -> tuple[int, int]: ...
    @property
    def projection(self) -> Array: ...


def _unchanged(pose: Array) -> Array:
    return pose


@dataclass(frozen=True, slots=True)
class SeenShape:
    """A shape's corners (N, 3), a view of it, and its pose (4 x 4) in the view's frame, given the pose looked for.

    Its edges are looked for `reach` times as far off as others: a near thing moves far in the picture. `inner`: also
    the edges between two faces of a box are looked for, as steps of the brightness.
    """

    shape: Array
    view: Coloured
    placed: Callable[[Array], Array] = _unchanged
    reach: float = 1.0
    inner: bool = False


@dataclass(frozen=True, slots=True)
class _Samples:
    """Points (N, 3) on a shape's edges, normals (N, 2), and where each edge was found (N, 2), up to `reach_px` off."""

    points: Array
    seen: SeenShape
    normals: Array
    ends: Array
    reach_px: float


class _AllSamples:
    """The samples of all shapes side by side, so that one product tells how far all of them are off."""

    def __init__(self, each: Sequence[_Samples]) -> None:
        self._seen = [samples.seen for samples in each]
        self._shape = np.repeat(np.arange(len(each)), [len(samples.points) for samples in each])
        points = np.concatenate([samples.points for samples in each])
        self._points = np.column_stack([points, np.ones(len(points))])
        self._normals = np.concatenate([samples.normals for samples in each])
        self._ends = np.concatenate([samples.ends for samples in each])
        self._clear_px = np.array([max(samples.reach_px, CLEAR_PX) for samples in each])[self._shape]

    def misses(self, looked_for: Sequence[Array]) -> Array:
        """Compute how far inside the colour's end each point is (poses, N), px, for each of the poses looked for."""
        views = np.array([[seen.view.projection @ seen.placed(pose) for seen in self._seen] for pose in looked_for])
        image = np.einsum("pnij,nj->pni", views[:, self._shape], self._points)
        pixels = image[..., :2] / np.maximum(image[..., 2:], 1e-6)
        return np.asarray(((self._ends - pixels) * self._normals).sum(axis=-1))

    def weights(self, misses: Array) -> Array:
        """Tukey's weights (N,): what is far off is another thing's edge, or one that is covered."""
        return np.asarray(np.maximum(1.0 - (misses / self._clear_px) ** 2, 0.0) ** 2)


def fit_edges(shapes: Sequence[SeenShape], expected: Array, sigmas: Array) -> Fitted | None:
    """The pose near the `expected` one (4 x 4) at which the outlines of all shapes end where their colours do.

    `sigmas` (6,) are those of the expected position (m) and rotation (rad). None where too little of it is seen.
    """
    pose, misses, weights = expected, np.empty(0), np.empty(0)
    total = np.zeros(6)
    for reach_px in REACHES_PX:
        each = [samples for shape in shapes if (samples := _samples(shape, pose, reach_px)) is not None]
        if not each:
            return None
        seen = _AllSamples(each)
        misses, *changed = seen.misses([pose, *(moved(pose, change) for change in TURN * np.eye(6))])
        weights = seen.weights(misses)
        if np.count_nonzero(weights) < LEAST_SAMPLES:
            return None
        jacobian = (np.array(changed) - misses).T / TURN * sigmas
        weighted = (jacobian * weights[:, None]).T / EDGE_SIGMA_PX**2
        step = np.linalg.solve(weighted @ jacobian + np.eye(6), -weighted @ misses - total)
        total = total + step
        pose = moved(pose, step * sigmas)
    return Fitted(pose, float(np.sqrt(np.average(misses**2, weights=weights))))


def project(projection: Array, points: Array) -> Array:
    """Pixels (N, 2) of points (N, 3)."""
    image = points @ projection[:, :3].T + projection[:, 3]
    return np.asarray(image[:, :2] / np.maximum(image[:, 2:], 1e-6))


def _samples(seen: SeenShape, looked_for: Array, reach_px: float) -> _Samples | None:
    shape, pose, reach_px = seen.shape, seen.placed(looked_for), reach_px * (seen.reach if reach_px > NEAR_PX else 1.0)
    points = shape @ pose[:3, :3].T + pose[:3, 3]
    if not (points @ seen.view.projection[2, :3] + seen.view.projection[2, 3] > 0).all():
        return None  # a corner behind the camera
    pixels = project(seen.view.projection, points)
    offsets = np.arange(-reach_px, reach_px + STEP_PX / 2, STEP_PX)
    around = _outwards(_sampled(shape, pixels, _outline_edges(pixels)), pixels.mean(axis=0))
    found = [_found(around, _ends(_profiles(seen.view.above, seen.view, around, offsets), offsets))]
    edges = _inner_edges(points, seen.view.projection) if seen.inner and reach_px <= NEAR_PX else NO_EDGES
    if len(edges):
        inside = _sampled(shape, pixels, edges)
        found.append(_found(inside, _steps(_profiles(seen.view.luma, seen.view, inside, offsets), offsets)))
    points, ends, normals = (np.concatenate(part) for part in zip(*found, strict=True))
    return _Samples(points, seen, normals, ends, reach_px) if len(points) else None


class _Sampled(NamedTuple):
    """Points (N, 3) along edges, where they are shown (N, 2), and the normals there (N, 2)."""

    points: Array
    places: Array
    normals: Array


def _outwards(sampled: _Sampled, middle: Array) -> _Sampled:
    """The same with normals that point away from the `middle` (2,) of the shape."""
    away = np.sign(((sampled.places - middle) * sampled.normals).sum(axis=1, keepdims=True))
    return sampled._replace(normals=sampled.normals * away)


def _found(sampled: _Sampled, ends: Array) -> _Sampled:
    """Those at which an edge was found, at `ends` (N,) px along their normals (NaN where not), and where it was."""
    found = ~np.isnan(ends)
    places = sampled.places[found] + ends[found, None] * sampled.normals[found]
    return _Sampled(sampled.points[found], places, sampled.normals[found])


def _sampled(shape: Array, pixels: Array, edges: Array) -> _Sampled:
    begins, ends = edges.T
    along = pixels[ends] - pixels[begins]
    length = np.hypot(along[:, 0], along[:, 1])
    count = np.clip(length / SPACING_PX, 2, MOST_SAMPLES).astype(int) * (length >= SHORTEST_PX)
    edge = np.repeat(np.arange(len(edges)), count)
    which = np.arange(len(edge)) - (np.cumsum(count) - count)[edge]
    at = (FROM_CORNER + (1.0 - 2.0 * FROM_CORNER) * which / (count[edge] - 1))[:, None]
    points, places = (of[begins[edge]] + at * (of[ends] - of[begins])[edge] for of in (shape, pixels))
    normals = along[:, ::-1] * (1.0, -1.0) / length[:, None]
    return _Sampled(points, places, normals[edge])


def _outline_edges(pixels: Array) -> Array:
    hull = cv2.convexHull(pixels.astype(np.float32), returnPoints=False)[:, 0]
    return np.column_stack([hull, np.roll(hull, -1)])


def _inner_edges(corners: Array, projection: Array) -> Array:
    """The edges (N, 2) between two faces that a view shows of a box; its corners (8, 3) as its coordinates count."""
    centre = -np.linalg.solve(projection[:, :3], projection[:, 3])
    axes = corners[list(NEXT_CORNERS)] - corners[0]
    sides = ((centre - corners.mean(axis=0)) @ axes.T / (axes**2).sum(axis=1)).tolist()  # in lengths from the middle
    edges = []
    for k in range(3):
        shown = [m for m in range(3) if m != k and abs(sides[m]) > HALF]
        if len(shown) == TWO_FACES:
            begin = sum(NEXT_CORNERS[m] for m in shown if sides[m] > 0)
            edges.append((begin, begin + NEXT_CORNERS[k]))
    return np.array(edges, dtype=int).reshape(-1, 2)


def _profiles(picture: Array, view: Coloured, sampled: _Sampled, offsets: Array) -> Array:
    """A part of a picture along the normals through places: (N, offsets); NaN beyond it."""
    if not len(sampled.places):
        return np.empty((0, len(offsets)))
    begins = (sampled.places - view.corner - 0.5).T[:, :, None]
    x, y = (begins + sampled.normals.T[:, :, None] * offsets).astype(np.float32)
    found = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=np.nan)
    return np.asarray(found, dtype=np.float64)


def _ends(profiles: Array, offsets: Array) -> Array:
    """At which offset each profile (N, M) of a colour ends, the outermost (N,); NaN where it does not."""
    ends = (profiles[:, :-1] > 0) & (profiles[:, 1:] <= 0)
    last = ends.shape[1] - 1 - ends[:, ::-1].argmax(axis=1)
    row = np.arange(len(profiles))
    inside, outside = profiles[row, last], profiles[row, last + 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        found = offsets[last] + STEP_PX * inside / (inside - outside)
    return np.where(ends.any(axis=1), found, np.nan)


def _steps(profiles: Array, offsets: Array) -> Array:
    """At which offset each profile (N, M) of the brightness has its steepest step (N,); NaN without a clear one."""
    steps = np.abs(profiles[:, 2 * ACROSS :] - profiles[:, : -2 * ACROSS])
    steps = np.where(np.isnan(steps), 0.0, steps)
    steepest = steps.argmax(axis=1)
    clear = steps[np.arange(len(steps)), steepest] > LEAST_STEP
    return np.where(clear, offsets[ACROSS + steepest], np.nan)
