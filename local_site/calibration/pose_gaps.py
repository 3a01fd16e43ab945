"""Gaps in the kept poses of a board: the places, tilts and distances that each view still lacks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.geometry import Array
from local_site.calibration.boards import Board, BoardView, Pose
from local_site.calibration.control_points import Size
from local_site.calibration.coverage import MIN_PICTURE, picture_coverage

ENOUGH_POSES = 10
ENOUGH_TILT_DEG = 40.0
ENOUGH_NEARER = 1.3
GUESSED_FOCAL = 0.9  # of the picture's longer side; it is not known before the calibration, and need not be exact here
NAMED_PLACES = 3
PLACES = (
    ("the upper left", "the upper edge", "the upper right"),
    ("the left edge", "the centre", "the right edge"),
    ("the lower left", "the lower edge", "the lower right"),
)


@dataclass(frozen=True, slots=True)
class BoardAspect:
    """A board as a view shows it: its distance in m, and how far its right and lower edges are turned nearer, deg."""

    distance: float
    right_nearer_deg: float
    lower_nearer_deg: float


def aspect_of(view: BoardView, board: Board, size: Size) -> BoardAspect:
    """Distance and tilts of a board in a picture of this size (width, height), by a guessed focal length."""
    focal, middle = GUESSED_FOCAL * max(size), np.array(size) / 2
    homography = cv2.findHomography(board.corners[view.ids, :2], (view.pixels - middle) / focal)[0]
    scaled = homography / np.mean(np.linalg.norm(homography[:, :2], axis=0))
    facing = scaled if scaled[2] @ (*board.middle[:2], 1.0) > 0 else -scaled
    centre: Array = facing @ (*board.middle[:2], 1.0)
    into = np.cross(facing[:, 0], facing[:, 1])
    right, lower = (float(np.degrees(np.arctan2(into[k], into[2]) - np.arctan2(centre[k], centre[2]))) for k in (0, 1))
    return BoardAspect(float(np.linalg.norm(centre)), right, lower)


def pose_gaps(poses: Sequence[Pose], board: Board, names: Sequence[str], sizes: Sequence[Size]) -> list[str]:
    """Say what is missing, a sentence for each view and kind, and how many poses; empty if it is enough.

    `poses` are what all views show of each pose; `names` and `sizes` (width, height in px) are those of the views.
    """
    sentences = []
    for name, size, own in zip(names, sizes, zip(*poses, strict=True) if poses else [()] * len(names), strict=True):
        seen = [view for view in own if view is not None]
        sentences += [f"{name} view: {gap}" for gap in _view_gaps(seen, board, size)]
    left = ENOUGH_POSES - len(poses)
    return sentences + ([f"{left} more pose{'s' if left > 1 else ''}"] if left > 0 else [])


def _view_gaps(seen: Sequence[BoardView], board: Board, size: Size) -> Iterator[str]:
    pixels = np.concatenate([np.zeros((0, 2)), *(view.pixels for view in seen)])
    covered = picture_coverage(pixels, size)
    if covered < MIN_PICTURE:
        places = ", ".join(empty_places(pixels, size)[:NAMED_PLACES]) or "all edges"
        yield f"{int(100 * covered)} % of its picture covered, needs {100 * MIN_PICTURE:.0f} %: show it at {places}"
    aspects = [aspect_of(view, board, size) for view in seen]
    yield from _tilt_gap([aspect.right_nearer_deg for aspect in aspects], "right", "left")
    yield from _tilt_gap([aspect.lower_nearer_deg for aspect in aspects], "lower", "upper")
    distances = [aspect.distance for aspect in aspects] or [1.0]
    if max(distances) < ENOUGH_NEARER * min(distances):
        yield f"bring it {100 * (ENOUGH_NEARER - 1):.0f} % nearer or farther away"


def empty_places(pixels: Array, size: Size) -> list[str]:
    """The ninths of a picture of this size (width, height) without any of the pixels (N, 2), by name."""
    edges = [np.linspace(0, extent, 4) for extent in size]
    counts = np.histogram2d(pixels[:, 0], pixels[:, 1], bins=(edges[0], edges[1]))[0]
    return [PLACES[row][column] for row, column in np.ndindex(3, 3) if counts[column, row] == 0]


def _tilt_gap(angles: Sequence[float], positive: str, negative: str) -> Iterator[str]:
    """The edge to turn nearer, if tilts (deg) towards both edges do not yet differ enough."""
    least, most = min(angles, default=0.0), max(angles, default=0.0)
    if most - least < ENOUGH_TILT_DEG:
        edge = positive if most <= -least else negative
        more = ENOUGH_TILT_DEG - (most - least)
        yield f"turn its {edge} edge nearer to the cameras, by {more:.0f} degrees more"
