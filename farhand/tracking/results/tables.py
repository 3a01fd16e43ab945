"""A track as text: a line of JSON or a row of CSV for each pair."""

import csv
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from farhand.outputs import written_at_end
from farhand.tracking.results.tracked_pair import Take, TrackedPair
from farhand.tracking.track_line import ALL_POINTS, POINTS

COLUMNS = (
    *("frame", "t_s", "status", "reason"),
    *(f"{name}_{axis}_m" for name in ALL_POINTS for axis in "xyz"),
    *(f"{name}_sigma_m" for name in POINTS),
    *("thumb_inferred", "hand_open", "gripper_toggles", "residual_px", "tracking_ms"),
)
NOWHERE = (None, None, None)


@contextmanager
def json_lines(out: Path) -> Iterator[Take]:
    """A file with a line of JSON for each pair; an earlier one stays until there is a line."""
    with written_at_end(out) as lines:
        yield lambda pair: lines.write(msgspec.json.encode(pair.line).decode() + "\n")


@contextmanager
def csv_rows(out: Path) -> Iterator[Take]:
    """A file with a row for each pair below the names of the columns; an earlier one stays until there is a row."""
    with written_at_end(out) as lines:
        yield lambda pair: lines.write(_text(*([COLUMNS] if pair.line.frame == 0 else []), _row(pair)))


def _text(*rows: tuple[object, ...]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def _row(pair: TrackedPair) -> tuple[object, ...]:
    """The cells of a pair; None becomes an empty one."""
    line = pair.line
    points = (coordinate for name in ALL_POINTS for coordinate in getattr(line, name) or NOWHERE)
    sigmas = (line.sigma[name] for name in POINTS)
    flags = (str(flag).lower() for flag in (line.thumb_inferred, line.hand_open))
    ends = line.gripper_toggles, line.residual_px, line.ms
    return line.frame, round(pair.t_s, 6), line.status.value, line.reason, *points, *sigmas, *flags, *ends
