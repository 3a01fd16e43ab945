"""The task file: written, read back, edited by hand with mistakes."""

import tomllib

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import replace

from common.errors import ConfigError
from farhand.teach.show import plotted
from farhand.teach.task_file import TaughtFrame, load_task
from farhand.teach.task_run import frame_from
from farhand.teach.writing import as_toml
from tests.farhand.teach.example_task import TASK


def test_what_was_written_is_read_back(tmp_path):
    file = tmp_path / "task.toml"
    file.write_text(as_toml(TASK))
    assert load_task(file) == TASK
    assert "mm" in file.read_text().splitlines()[1]


def test_mistakes_are_named_all_at_once_with_their_lines(tmp_path):
    file = tmp_path / "task.toml"
    text = as_toml(TASK).replace('gripper = "closed"', 'gripper = "shut"').replace("speed_mm_s = 80", "sped_mm_s = 80")
    file.write_text(text)
    with pytest.raises(ConfigError) as error:
        load_task(file)
    assert "shut" in str(error.value)
    assert "sped_mm_s" in str(error.value)


def test_a_number_that_is_not_finite_and_a_single_way_point_are_refused(tmp_path):
    file = tmp_path / "task.toml"
    file.write_text(as_toml(TASK).replace("[0.00, 0.00, 50.00]", "[nan, 0.00, 50.00]"))
    with pytest.raises(ConfigError, match="finite"):
        load_task(file)
    file.write_text(as_toml(TASK).rpartition("[[waypoints]]")[0])
    with pytest.raises(ConfigError, match=r"waypoints: a list of 1 is not allowed: give a list of at least 2"):
        load_task(file)


@pytest.mark.parametrize(
    ("line", "mistaken"),
    [
        ("speed_mm_s = 80", "speed_mm_s = 0.08"),
        ("speed_mm_s = 80", "speed_mm_s = -80"),
        ("speed_mm_s = 80", "speed_mm_s = nan"),
        ("turn_deg_s = 45", "turn_deg_s = 0.79"),
        ("acceleration_mm_s2 = 400", "acceleration_mm_s2 = 0.4"),
        ("jerk_mm_s3 = 4000", "jerk_mm_s3 = 4"),
        ("dwell_s = 0.5", "dwell_s = 500"),
    ],
)
def test_a_number_in_other_units_is_refused(tmp_path, line, mistaken):
    file = tmp_path / "task.toml"
    file.write_text(as_toml(TASK).replace(line, mistaken))
    with pytest.raises(ConfigError, match=f"{mistaken.split()[0]}: {mistaken.split()[2]} is not allowed"):
        load_task(file)


def test_a_frame_is_given_as_an_option():
    assert frame_from("") is None
    assert frame_from("1,2,3") == TaughtFrame(xyz_mm=(1.0, 2.0, 3.0))
    assert frame_from("1,2,3,45") == TaughtFrame(xyz_mm=(1.0, 2.0, 3.0), rpy_deg=(0.0, 0.0, 45.0))
    for wrong in ("1,2", "1,2,3,4,5", "a,b,c", "nan,0,0"):
        with pytest.raises(ConfigError, match="in mm and deg"):
            frame_from(wrong)


@given(st.text())
@example('x"\n[motion]\nspeed_mm_s = 1000\n# \u2028 \x85 \x00 \U000e0001')
def test_a_recorded_tasks_name_stays_a_name(name):
    task = TASK.task
    hostile = replace(TASK, task=replace(task, name=name, robot=name, recorded=name))
    plain = tomllib.loads(as_toml(TASK))
    named = plain["task"] | {"name": name, "robot": name, "recorded": name}
    assert tomllib.loads(as_toml(hostile)) == plain | {"task": named}


def test_a_tasks_name_is_no_formula_in_its_picture():
    pytest.importorskip("matplotlib")
    name = r"$\notaformula{$"
    figure = plotted(replace(TASK, task=replace(TASK.task, name=name)))
    assert figure.get_suptitle() == name
