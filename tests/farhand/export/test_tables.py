"""A session as CSV: a row an instant, units in the head."""

import csv
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from common.errors import ConfigError, ExportError, InterruptionError
from farhand.export.session import episode_at
from farhand.export.tables import export_csv, head
from tests.farhand.export.made_session import EPOCH_NS, MadeSession, at_s, joints


def never():
    return False


def rows_of(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_every_instant_has_a_row_whose_figures_are_the_session(tmp_path):
    made = MadeSession()
    (path,) = export_csv([made], tmp_path / "tables", 50, never)
    assert path.name == "made.csv"
    rows = rows_of(path)
    assert len(rows) == 250
    row = rows[100]
    assert float(row["t [s]"]) == 2.0
    assert int(row["t [ns UTC]"]) == EPOCH_NS + 2_000_000_000
    assert float(row["elbow measured [rad]"]) == pytest.approx(joints(np.array([at_s(2.0)]), 0.0)[0, 2], abs=1e-8)
    assert (row["session"], row["episode"], row["task"]) == ("engaged", "1", "put the block on the mark")
    assert int(row["sent [ns UTC]"]) == EPOCH_NS + 1_997_000_000
    assert datetime.fromtimestamp(int(row["t [ns UTC]"]) / 1e9, UTC).year == 2026


def test_what_is_not_known_yet_is_empty_and_between_episodes_there_is_none(tmp_path):
    (path,) = export_csv([MadeSession()], tmp_path, 50, never)
    rows = rows_of(path)
    assert rows[0]["elbow sent [rad]"] == rows[0]["sent [ns UTC]"] == rows[0]["episode"] == ""
    assert rows[0]["elbow measured [rad]"] != ""
    assert rows[130]["episode"] == ""
    assert rows[150]["task"] == "öffne die Schublade"


def test_every_column_of_a_figure_names_its_unit(tmp_path):
    (path,) = export_csv([MadeSession(has_gripper=False)], tmp_path, 10, never)
    head = path.read_text(encoding="utf-8").splitlines()[0].split(",")
    assert [name for name in head if "[" not in name] == ["session", "episode", "task"]
    assert not [name for name in head if "gripper" in name]


@pytest.mark.parametrize("task", ["=1+1", "+1", "-1", "@sum", "\t=1"])
def test_a_task_that_a_spreadsheet_would_calculate_is_text_and_figures_stay_figures(task, tmp_path):
    (path,) = export_csv([MadeSession(tasks=(task, task))], tmp_path, 50, never)
    row = rows_of(path)[100]
    assert row["task"] == f"'{task}"
    assert any(value.startswith("-") for value in row.values())


def test_a_joint_that_a_spreadsheet_would_calculate_is_text():
    facts = replace(MadeSession().facts, joint_names=("=elbow", "waist"))
    assert head(facts)[5:7] == ["'=elbow measured [rad]", "waist measured [rad]"]


def test_episode_ends_before_its_end():
    facts = MadeSession().facts
    assert [e and e.number for e in (episode_at(facts, at_s(t)) for t in (0.4, 0.5, 2.499, 2.5, 2.8))] == [
        None, 1, 1, None, 2,
    ]  # fmt: skip


def test_a_table_is_never_written_over_and_none_is_left_half(tmp_path):
    with pytest.raises(InterruptionError):
        export_csv([MadeSession()], tmp_path, 50, lambda: True)
    assert list(tmp_path.iterdir()) == []
    export_csv([MadeSession()], tmp_path, 10, never)
    before = (tmp_path / "made.csv").read_bytes()
    with pytest.raises(ConfigError, match="give another --out"):
        export_csv([MadeSession(phase=1.0)], tmp_path, 10, never)
    assert (tmp_path / "made.csv").read_bytes() == before
    with pytest.raises(ExportError, match="same name"):
        export_csv([MadeSession("two"), MadeSession("two")], tmp_path, 10, never)
