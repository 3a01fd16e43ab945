"""A track as lines of JSON and rows of CSV: units in the names, empty where unknown, complete or not there."""

import csv
import json
from pathlib import Path

import pytest

from farhand.tracking.results.outputs import COLUMNS, csv_rows, json_lines
from tests.farhand.tracking.results.tracked import pair, write_then_fail

WRIST = (0.1, 0.25, -0.5)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_row_has_the_figures_of_its_line_and_is_empty_where_they_are_unknown(tmp_path: Path) -> None:
    with csv_rows(tmp_path / "t.csv") as take, json_lines(tmp_path / "t.jsonl") as take_line:
        for found in (pair(0), pair(1, WRIST, sigma_mm=2.0, residual_px=0.3456)):
            take(found)
            take_line(found)
    lost, tracked = rows(tmp_path / "t.csv")
    assert {name for name in COLUMNS if lost[name]} == {
        *("frame", "t_s", "status", "thumb_inferred", "hand_open", "gripper_toggles", "tracking_ms")
    }
    assert (lost["t_s"], tracked["t_s"], tracked["status"], tracked["hand_open"]) == ("0.0", "0.04", "tracked", "false")
    assert tuple(float(tracked[f"wrist_{axis}_m"]) for axis in "xyz") == WRIST
    assert (tracked["wrist_sigma_m"], tracked["residual_px"], tracked["elbow_x_m"]) == ("0.002", "0.346", "")
    line = json.loads((tmp_path / "t.jsonl").read_text().splitlines()[1])
    assert (line["wrist"], line["residual_px"]) == ([*WRIST], 0.346)


def test_a_reason_with_commas_and_quotes_is_one_cell(tmp_path: Path) -> None:
    reason = 'out of sync, exchanged, or "moved"'
    with csv_rows(tmp_path / "t.csv") as take:
        take(pair(0, reason=reason))
    (row,) = rows(tmp_path / "t.csv")
    assert row["reason"] == reason


def test_every_unit_is_in_its_columns_name() -> None:
    assert [name for name in COLUMNS if not name.endswith(("_m", "_s", "_px", "_ms"))] == [
        *("frame", "status", "reason", "thumb_inferred", "hand_open", "gripper_toggles")
    ]


@pytest.mark.parametrize(("pairs", "kept"), [(0, True), (1, False)])
def test_an_earlier_table_stays_until_there_is_a_row(tmp_path: Path, pairs: int, kept: bool) -> None:
    out = tmp_path / "t.csv"
    out.write_text("earlier\n")
    with pytest.raises(OSError, match="gone"):
        write_then_fail(csv_rows(out), pairs, OSError("the disk is gone"))
    assert (out.read_text() == "earlier\n") is kept
    assert list(tmp_path.iterdir()) == [out]
