"""Control points: known points and where each camera saw them, read from a CSV file."""

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common.errors import CalibrationError
from common.geometry import Array

POSITION = ("X_mm", "Y_mm", "Z_mm")
CAMERAS = ("left", "right", "third", "fourth")
COLUMNS = (("uL_px", "vL_px"), ("uR_px", "vR_px"), ("u3_px", "v3_px"), ("u4_px", "v4_px"))
HEADERS = tuple((*POSITION, *(name for pair in COLUMNS[:count] for name in pair)) for count in (2, 3, 4))
HEADER = HEADERS[0]
MAX_NAMED = 20

Size = tuple[int, int]


@dataclass(frozen=True, slots=True)
class ControlPoints:
    """N points (N, 3) in m in the operator frame, their pixels (N, 2) in each camera (NaN where unseen), their names.

    `labels` state where a person finds each point (a line of a file, a disc of a plate); `sizes` are width and height
    of each camera's picture in px, where known.
    """

    points: Array
    pixels: tuple[Array, ...]
    labels: tuple[str, ...]
    source: str
    sizes: tuple[Size | None, ...] = (None,) * len(CAMERAS)

    @property
    def cameras(self) -> tuple[str, ...]:
        """The cameras' names."""
        return CAMERAS[: len(self.pixels)]


def read_control_points(path: Path, size: Size | None = None) -> ControlPoints:
    """Read a control point file of two to four cameras; CalibrationError lists every mistake with line and cure."""
    try:
        rows = list(csv.reader(path.read_text(encoding="utf-8-sig").splitlines()))
    except OSError as error:
        why = f"{error.strerror}; give the path of a CSV file that is there and may be read"
        raise CalibrationError(f"cannot read control points from {path}: {why}") from error
    except UnicodeDecodeError as error:
        raise CalibrationError(f"{path} is not UTF-8 text; save it as CSV in UTF-8") from error
    except csv.Error as error:
        raise CalibrationError(f"cannot read control points from {path}: {error}; give a CSV text file") from error
    header = tuple(cell.strip() for cell in rows[0]) if rows else ()
    if header not in HEADERS:
        more = " (and ,u3_px,v3_px and ,u4_px,v4_px for a third and a fourth camera)"
        raise CalibrationError(f"{path}, line 1: the header must be {','.join(HEADER)}{more}")
    numbered = [(line, row) for line, row in enumerate(rows[1:], start=2) if any(cell.strip() for cell in row)]
    mistakes = [mistake for line, row in numbered for mistake in _mistakes(line, row, header)] + _repeated(numbered)
    if mistakes:
        raise refusal(path.name, mistakes)
    values = [[float(cell) if cell.strip() else math.nan for cell in row] for _, row in numbered]
    table = np.array(values).reshape(-1, len(header))
    pixels = tuple(table[:, k : k + 2] for k in range(len(POSITION), len(header), 2))
    labels = tuple(f"line {line}" for line, _ in numbered)
    return ControlPoints(table[:, :3] / 1000.0, pixels, labels, path.name, (size,) * len(pixels))


def refusal(source: str, mistakes: Sequence[str]) -> CalibrationError:
    """The error that lists the mistakes of a calibration's input, the first MAX_NAMED in full."""
    more = [] if len(mistakes) <= MAX_NAMED else [f"... and {len(mistakes) - MAX_NAMED} more"]
    return CalibrationError("\n  ".join([f"{source} cannot give a calibration:", *mistakes[:MAX_NAMED], *more]))


def _mistakes(line: int, row: Sequence[str], header: Sequence[str]) -> Iterator[str]:
    if len(row) != len(header):
        yield f"line {line}: {len(row)} columns, not {len(header)}; leave a cell empty where a point is not seen"
        return
    for name, cell in zip(header, row, strict=True):
        yield from _cell_mistakes(line, name, cell.strip())
    for k, camera in enumerate(CAMERAS[: (len(header) - len(POSITION)) // 2]):
        if bool(row[3 + 2 * k].strip()) != bool(row[4 + 2 * k].strip()):
            yield f"line {line}: only one pixel coordinate for the {camera} camera; give both or leave both empty"


def _cell_mistakes(line: int, name: str, cell: str) -> Iterator[str]:
    if not cell:
        if name in POSITION:
            yield f"line {line}: {name} is empty; every control point needs its measured position"
        return
    try:
        finite = math.isfinite(float(cell))
    except ValueError:
        yield f"line {line}: {name} is {cell[:30]!r}, not a number; correct it or leave out the line"
        return
    if not finite:
        yield f"line {line}: {name} is {cell}; correct it or leave out the line"


def _repeated(numbered: Sequence[tuple[int, Sequence[str]]]) -> list[str]:
    first: dict[tuple[str, ...], int] = {}
    mistakes = []
    for line, row in numbered:
        seen = first.setdefault(tuple(cell.strip() for cell in row[:3]), line)
        if seen != line:
            mistakes.append(f"line {line}: the same point as line {seen}; leave out one of them")
    return mistakes
