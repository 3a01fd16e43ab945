"""The page with the calibration board: to be printed at 100 %, with rulers that show whether it was."""

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from farhand.setup.pdf import BlackRectangle, PrintedPage, PrintedWords
from local_site.calibration.boards import Board

PAPERS = {"A4": (297.0, 210.0), "Letter": (279.4, 215.9)}
BOARD = Board("charuco", 8, 6, 0.030, 0.022)
RULER_MM = 100.0

TOP_MM = 8.0
RULER_GAP_MM = 5.0
LINE_MM = 0.25
TICK_MM, LONG_TICK_MM = 1.5, 3.0
INCH_MM = 25.4
LETTER_MM = 2.6
BETWEEN_RULERS_MM = 14.0


def board_page(board: Board, paper: tuple[float, float]) -> PrintedPage:
    """A ChArUco board on a landscape page of this width and height in mm, above two rulers and a line of words."""
    width, height = paper
    square = 1000 * board.square
    left = (width - board.columns * square) / 2
    bottom = TOP_MM + board.rows * square
    rulers = bottom + RULER_GAP_MM
    inches = left + RULER_MM + BETWEEN_RULERS_MM
    return PrintedPage(
        width,
        height,
        (
            *_printed(board, left, TOP_MM),
            *_ruler(left, rulers, RULER_MM / 10, 10),
            *_ruler(inches, rulers, INCH_MM / 2, 8),
        ),
        (
            PrintedWords(left, rulers + 6.5, LETTER_MM, "100 mm"),
            PrintedWords(inches, rulers + 6.5, LETTER_MM, "4 in"),
            PrintedWords(left, rulers + 11.5, LETTER_MM, _advice(board)),
        ),
    )


def _advice(board: Board) -> str:
    return (
        f"Print at 100 %, measure the ruler: it must be 100 mm. ChArUco board, {board.columns} x {board.rows} squares "
        f"of {1000 * board.square:g} mm, markers {1000 * board.marker:g} mm, DICT_{board.dictionary}. Glue it on "
        "something flat."
    )


def _printed(board: Board, left: float, top: float) -> Iterator[BlackRectangle]:
    """The board's black parts, its upper left corner there, mm."""
    square, marker = 1000 * board.square, 1000 * board.marker
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{board.dictionary}"))
    printed = cv2.aruco.CharucoBoard((board.columns, board.rows), square, marker, dictionary)
    for row, column in np.ndindex(board.rows, board.columns):
        if (row + column) % 2 == 0:
            yield BlackRectangle(left + column * square, top + row * square, square, square)
    side = dictionary.markerSize + 2
    for number, corners in zip(np.ravel(printed.getIds()).tolist(), printed.getObjPoints(), strict=True):
        black = np.asarray(dictionary.generateImageMarker(number, side)) == 0
        x, y = np.asarray(corners)[0, :2].tolist()
        yield from _runs(black, left + x, top + y, marker / side)


def _runs(black: NDArray[np.bool_], left: float, top: float, module: float) -> Iterator[BlackRectangle]:
    """The black modules (N, N) of a marker, a rectangle for each run of them in a row."""
    for row, own in enumerate(black):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], own.astype(np.int8), [0]]))).reshape(-1, 2)
        for begin, end in edges.tolist():
            yield BlackRectangle(left + begin * module, top + row * module, (end - begin) * module, module)


def _ruler(left: float, top: float, step: float, count: int) -> Iterator[BlackRectangle]:
    """A ruler of so many steps in mm, from the middle of its first tick to that of its last."""
    yield BlackRectangle(left - LINE_MM / 2, top, count * step + LINE_MM, LINE_MM)
    for k in range(count + 1):
        tick = LONG_TICK_MM if k in (0, count) else TICK_MM
        yield BlackRectangle(left + k * step - LINE_MM / 2, top, LINE_MM, tick)
