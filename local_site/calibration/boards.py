"""Printed boards: ChArUco boards and chessboards, their corners in a picture, and how sharply it shows them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.errors import ConfigError
from common.geometry import Array
from local_site.kernels.pictures import as_grey

BoardKind = Literal["charuco", "chessboard"]

MIN_CORNERS = 8
MAX_SQUARES = 60
DEFAULT_DICTIONARY = "5X5_250"
REACH_PX = 7  # from a corner, along its edges
GRADIENT_VARIANCE = 2 / 3  # of Sobel's own smoothing along the edge's normal, px²


@dataclass(frozen=True, slots=True)
class Board:
    """A board of squares in columns and rows; lengths in m. Markers and dictionary are a ChArUco board's only."""

    kind: BoardKind
    columns: int
    rows: int
    square: float
    marker: float = 0.0
    dictionary: str = DEFAULT_DICTIONARY

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < 3 or max(self.columns, self.rows) > MAX_SQUARES:
            raise ConfigError(f"--squares must be 3 to {MAX_SQUARES} per side, not {self.columns}x{self.rows}")
        if self.kind == "charuco" and not 0 < self.marker < self.square:
            raise ConfigError(
                "--marker-mm must be larger than 0 and smaller than --square-mm; measure both on the print"
            )
        if self.kind == "charuco" and not hasattr(cv2.aruco, f"DICT_{self.dictionary}"):
            raise ConfigError(f"--dictionary must be one such as 4X4_50, 5X5_250 or 6X6_1000, not {self.dictionary!r}")

    @property
    def corners(self) -> Array:
        """Inner corners ((columns-1)(rows-1), 3) in m: x right, y down the print, row by row from its upper left."""
        y, x = np.mgrid[1 : self.rows, 1 : self.columns]
        return self.square * np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]).astype(np.float64)

    @property
    def middle(self) -> Array:
        """The middle of the print (3,), m."""
        return self.square / 2 * np.array([self.columns, self.rows, 0.0])


@dataclass(frozen=True, slots=True)
class BoardView:
    """The corners of a board that a picture shows: their numbers (M,) and pixels (M, 2)."""

    ids: NDArray[np.int64]
    pixels: Array


class BoardFinder:
    """Finds one kind of board in pictures."""

    def __init__(self, board: Board) -> None:
        self._board = board
        if board.kind == "charuco":
            dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{board.dictionary}"))
            printed = cv2.aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary)
            self._detector = cv2.aruco.CharucoDetector(printed)

    def find(self, picture: Image) -> BoardView | None:
        """The board in a picture; None if it is not seen, or too little of it."""
        grey = as_grey(picture)
        view = self._charuco(grey) if self._board.kind == "charuco" else self._chessboard(grey)
        return view if view is not None and len(view.ids) >= MIN_CORNERS else None

    def finds_mirrored(self, picture: Image) -> bool:
        """Check whether the mirrored picture shows the board: then the camera mirrors. A chessboard does not tell."""
        flipped = np.ascontiguousarray(as_grey(picture)[:, ::-1])
        return self._board.kind == "charuco" and self.find(picture) is None and self.find(flipped) is not None

    def _charuco(self, grey: Image) -> BoardView | None:
        corners, ids, _, _ = self._detector.detectBoard(grey)
        if corners is None or ids is None or len(ids) == 0:
            return None
        clear = (self._board.square - self._board.marker) / (2 * self._board.square)
        rough = np.asarray(corners, dtype=np.float32).reshape(-1, 2)
        return BoardView(np.asarray(ids, dtype=np.int64).ravel(), _sharpened(rough, clear * _spacing(rough), grey))

    def _chessboard(self, grey: Image) -> BoardView | None:
        columns, rows = self._board.columns - 1, self._board.rows - 1
        flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
        found, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=flags)
        if not found:
            return None
        rough = np.asarray(corners, dtype=np.float32).reshape(-1, 2)
        grid = _sharpened(rough, _spacing(rough) / 3, grey).reshape(rows, columns, 2)
        return BoardView(np.arange(rows * columns), _ordered(grid, grey).reshape(-1, 2))


def _spacing(corners: NDArray[np.float32]) -> float:
    """Return the distance between the nearest two of the corners (M, 2), px."""
    apart = np.linalg.norm(corners[:, None] - corners[None], axis=2)
    return float(np.min(apart + np.diag(np.full(len(corners), np.inf)))) if len(corners) > 1 else 0.0


def _sharpened(corners: NDArray[np.float32], reach_px: float, grey: Image) -> Array:
    """Corners (M, 2) to a fraction of a pixel, from the edges within reach: as much of the print as is theirs alone."""
    half = int(np.clip(reach_px, 2, 11))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 30, 0.001)
    fine = cv2.cornerSubPix(grey, corners.reshape(-1, 1, 2).copy(), (half, half), (-1, -1), stop)
    return np.asarray(fine, dtype=np.float64).reshape(-1, 2)


def _ordered(grid: Array, grey: Image) -> Array:
    """Corners (rows, columns, 2) named as on the print: not mirrored, and its first inner square black.

    On a board whose columns and rows are both even or both odd the squares do not distinguish its two ends; then rows
    run to the right of the picture.
    """
    across, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if across[0] * down[1] - across[1] * down[0] < 0:
        grid = grid[:, ::-1]
    greys = [_square_grey(grey, corner) for corner in (grid[:2, :2], grid[-2:, -2:])]
    rows, columns, _ = grid.shape
    turned = greys[0] > greys[1] if (rows + columns) % 2 else bool(grid[0, -1, 0] < grid[0, 0, 0])
    return grid[::-1, ::-1] if turned else grid


def _square_grey(grey: Image, corners: Array) -> float:
    u, v = (round(float(value)) for value in corners.reshape(-1, 2).mean(axis=0))
    patch = grey[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2]
    return float(patch.mean()) if patch.size else 0.0


def edge_blur_px(grey: Image, corners: Array) -> float:
    """The blur of the edges around a board's corners (M, 2) in a grey picture (H, W): a Gaussian's sigma, median, px.

    Infinite if no corner is far enough from the picture's border.
    """
    steepness = [_steepness(grey, u, v) for u, v in np.round(corners).astype(int).tolist()]
    known = [value for value in steepness if value is not None]
    if not known:
        return float(np.inf)
    # The greatest slope of a step that is blurred by sigma is its height over sigma sqrt(2 pi).
    sigma = 1.0 / (max(float(np.median(known)), 1e-6) * np.sqrt(2 * np.pi))
    return float(np.sqrt(max(sigma**2 - GRADIENT_VARIANCE, 0.0)))


def _steepness(grey: Image, u: int, v: int) -> float | None:
    """The greatest slope around a corner over the step's height, 1/px; None at the border."""
    height, width = grey.shape
    reach = REACH_PX
    if not (reach <= u < width - reach and reach <= v < height - reach):
        return None
    patch = grey[v - reach : v + reach + 1, u - reach : u + reach + 1].astype(np.float32)
    dark, bright = np.percentile(patch, (10, 90))
    across, down = (cv2.Sobel(patch, cv2.CV_32F, *order, scale=1 / 8) for order in ((1, 0), (0, 1)))
    slope = float(np.percentile(np.hypot(across, down), 98))
    return slope / max(float(bright - dark), 1.0)


Pose = Sequence[BoardView | None]

STILL_PX = 1.0
STILL_FRAMES = 5
NEW_PX = 30.0
MIN_CAMERAS = 2


class PoseGate:
    """Selects the poses to keep, `taken`, from what all cameras see at each instant."""

    def __init__(self) -> None:
        self.taken: list[Pose] = []
        self._last: Pose = ()
        self._still = 0

    def offer(self, pose: Pose) -> bool:
        """Keep a pose that two cameras see, still for some frames, and new to one of them; return whether it was."""
        seen = sum(view is not None for view in pose) >= MIN_CAMERAS
        unmoved = seen and bool(self._last) and moved(pose, self._last) < STILL_PX
        self._still = self._still + 1 if unmoved else 0
        self._last = pose if seen else ()
        if self._still < STILL_FRAMES or any(moved(pose, old) < NEW_PX for old in self.taken):
            return False
        self.taken.append(pose)
        self._still = 0
        return True


def moved(pose: Pose, other: Pose) -> float:
    """Return how far the corners moved on average, px, where they moved most; infinite if no camera has both."""
    distances = [_distance(a, b) for a, b in zip(pose, other, strict=True) if a is not None and b is not None]
    return max(distances, default=np.inf)


def _distance(a: BoardView, b: BoardView) -> float:
    _, mine, theirs = np.intersect1d(a.ids, b.ids, return_indices=True)
    if len(mine) == 0:
        return float(np.inf)
    return float(np.mean(np.linalg.norm(a.pixels[mine] - b.pixels[theirs], axis=1)))
