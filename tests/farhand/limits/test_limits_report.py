"""What `farhand limits` prints: the limits with their sources, and the stops, as docs/safety.md quotes them."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from common.errors import ConfigError
from farhand.cli import app
from tests.remote_site.arms_followed import ARMS

DOCUMENT = Path(__file__).parents[3] / "docs" / "safety.md"
BEGIN, END = "<!-- what farhand limits prints -->\n\n", "\n<!-- as far as here -->"


def cells_of(output: str) -> list[list[str]]:
    """The lines of an output, each as its cells; titles and empty lines are one cell, rules under heads none."""
    return [re.split(r"\s{2,}", line.strip()) for line in output.splitlines() if not line.strip().startswith("─")]


def rows_of(output: str) -> dict[str, list[str]]:
    """The rows of all tables by their first cell; of each limit the joints' values, and where it comes from."""
    cells = [row for row in cells_of(output) if row != [""]]
    begin, end = next(k for k, row in enumerate(cells) if row[0] == "joint"), cells.index(["Where they come from:"])
    by_limit = {name: list(values) for name, *values in zip(*cells[begin:end], strict=True)}
    return {first: [*by_limit.get(first, ()), *others] for first, *others in cells[end:] if others}


def printed(*settings: str) -> dict[str, list[str]]:
    """The rows of all tables for a configuration."""
    done = CliRunner().invoke(app, ["limits", *(part for setting in settings for part in ("--set", setting))])
    assert done.exit_code == 0, done.exception
    return rows_of(done.output)


def test_the_document_quotes_what_it_prints_for_the_shipped_configuration():
    done = CliRunner().invoke(app, ["limits"])
    quoted = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0].splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in quoted if not line.startswith("| ---")]
    assert [row for row in cells_of(done.output) if row != [""]] == [row for row in rows if row != [""]]


def test_a_table_is_for_people(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")  # rich's word for a terminal
    monkeypatch.setenv("TERM", "xterm")
    shown = re.sub(r"\x1b\[[\d;]*m", "", CliRunner().invoke(app, ["limits"]).output)
    assert max(len(line) for line in shown.splitlines() if line.startswith(" ")) <= 80
    monkeypatch.delenv("TTY_COMPATIBLE")
    for output in (shown, CliRunner().invoke(app, ["limits"]).output):
        assert not set(output) & set("|…")


def test_a_file_is_read_and_its_limits_are_named_as_its_own(tmp_path):
    file = tmp_path / "remote.toml"
    file.write_text(
        "[robot]\nspeed = 0.5\njerk_rad_s3 = 400.0\nposition_deg = { joint_2 = [-60.0, 45.0] }\n"
        "[safety]\nt_soft_ms = 200.0\n"
    )
    done = CliRunner().invoke(app, ["limits", "--config", str(file)])
    rows = rows_of(done.output)
    assert rows["speed, rad/s"] == [*["1.57"] * 3, "1.49", "1.51", "1.49", "robot.speed = 0.5 of the arm's file"]
    assert rows["jerk, rad/s³"][-1] == "robot.jerk_rad_s3; the arm's file allows 1000"
    of_joint = "robot.position_deg for joint_2, else the arm's file, less robot.position_margin_deg = 1"
    assert rows["lowest, deg"][-1] == of_joint
    ages = done.output.split("From the exposure")[1]
    assert rows["200 ms"][0] == "0.785 rad/s"
    assert ages.count(" rad/s ") == 1


def test_an_arm_whose_file_states_little_is_said_to_do_so(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text((ARMS / "offset_wrist.urdf").read_text().replace(' jerk="1000"', ""))
    rows = printed(f"robot.model={urdf}", "robot.acceleration_rad_s2=[10.0]")
    assert rows["jerk, rad/s³"][-1] == "100 where the arm's file states none"
    assert rows["acceleration, rad/s²"][-1] == "robot.acceleration_rad_s2; the arm's file states none"


def test_a_factor_is_tried_without_a_change_of_the_file(tmp_path):
    file = tmp_path / "remote.toml"
    written = "[robot]\nspeed = 0.5\nlimits_factor = 0.8\n"
    file.write_text(written)
    done = CliRunner().invoke(app, ["limits", "--config", str(file), "--factor", "0.5"])
    source = "robot.speed = 0.5 of the arm's file times robot.limits_factor = 0.5"
    rows = rows_of(done.output)
    assert rows["speed, rad/s"] == ["0.785", "0.785", "0.785", "0.746", "0.755", "0.746", source]
    assert rows["factor on speed, acceleration and jerk"] == ["0.5", "robot.limits_factor"]
    assert file.read_text() == written


@pytest.mark.parametrize("factor", ["3", "0.001"])
def test_a_factor_out_of_range_is_refused_by_the_name_that_the_user_gave_it(factor):
    done = CliRunner().invoke(app, ["limits", "--factor", factor])
    assert done.exit_code == 2
    assert "Invalid value for '--factor'" in done.output
    assert "or equal to" in done.output
    assert "--set" not in done.output
    for end in ("0.01", "1"):
        assert CliRunner().invoke(app, ["limits", "--factor", end]).exit_code == 0


def test_what_an_import_assumed_is_said_until_it_is_corrected(tmp_path):
    urdf = tmp_path / "arm.urdf"
    marks = 'jerk="1000" assumed_jerk="1000" assumed_acceleration="7" assumed_effort="150"'
    urdf.write_text((ARMS / "offset_wrist.urdf").read_text().replace('jerk="1000"', marks))
    seven, by = ("robot.acceleration_rad_s2=[7.0]", f"robot.model={urdf}"), "assumed by farhand arm import"
    rows = printed(*seven)
    assert rows["jerk, rad/s³"][-1] == by
    assert rows["acceleration, rad/s²"][-1] == f"robot.acceleration_rad_s2, {by}; the arm's file states none"
    assert rows["effort, N m"][-1].startswith(f"{by} for pan, lift, elbow; else the arm's file;")
    assert rows["lowest, deg"][-1].startswith("the arm's file, less")
    rows = printed(*seven, "robot.acceleration_rad_s2=[8.0]", "robot.jerk_rad_s3=900")
    assert rows["jerk, rad/s³"][-1] == f"robot.jerk_rad_s3; the arm's file allows 1000 ({by})"
    assert rows["acceleration, rad/s²"][-1] == "robot.acceleration_rad_s2; the arm's file states none"
    urdf.write_text(urdf.read_text().replace(' jerk="1000"', ' jerk="3000"', 1))
    assert (
        printed(*seven)["jerk, rad/s³"][-1] == f"{by} for lift, elbow, wrist_1, wrist_2, wrist_3; else the arm's file"
    )
    urdf.write_text(urdf.read_text().replace("assumed_jerk", "given_jerk"))
    assert printed(*seven)["jerk, rad/s³"][-1].startswith("given to farhand arm import for lift, elbow")


def test_what_is_the_a465s_is_said_so_on_another_arm(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text((ARMS / "offset_wrist.urdf").read_text())
    rows = printed(f"robot.model={urdf}", "robot.acceleration_rad_s2=[10.0]")
    assert rows["capsules on tool0"][-1] == "robot.capsules, the shape of the A465's gripper: give your own"
    assert rows["acceleration, rad/s²"][-1].startswith("robot.acceleration_rad_s2; ")
    assert printed()["capsules on tool0"][-1] == "robot.capsules, by default the A465's gripper"


def test_an_acceleration_that_is_the_a465s_by_default_is_said_so_on_another_arm():
    rows = printed(f"robot.model={ARMS / 'offset_wrist.urdf'}")
    assert rows["acceleration, rad/s²"][-1].startswith(
        "robot.acceleration_rad_s2, by default the A465's: give your own"
    )
    assert "default" not in printed()["acceleration, rad/s²"][-1]


def test_the_factor_is_named_at_each_limit_that_it_tightens_and_no_stop_takes_longer():
    full, half = printed(), printed("robot.limits_factor=0.5")
    tightened = [name for name, row in half.items() if "times robot.limits_factor = 0.5" in row[-1]]
    assert tightened == ["speed, rad/s", "acceleration, rad/s²", "jerk, rad/s³"]
    assert not [name for name, row in full.items() if "times robot.limits_factor" in row[-1]]
    assert half["acceleration, rad/s²"][:-1] == ["5", "5", "5", "10", "10", "10"]
    assert half["longest stop, ms"] == full["longest stop, ms"]
    assert half["1.57 rad/s, full speed"][2] == full["3.14 rad/s, full speed"][2] == "334 ms"
    assert half["1.57 rad/s, full speed"][3] == "228 mm, 669 mm"


def test_tool_payload_and_box_are_shown_with_their_keys():
    rows = printed(
        "robot.tool_offset_m=0.2",
        "robot.payload_kg=1.5",
        "grip.force_n=40",
        "safety.workspace_max_m=[0.7, 0.5, 1.0]",
    )
    assert rows["tool centre point in it, mm"] == ["0, 0, 200", "robot.tool_offset_m, along z"]
    assert rows["payload beyond the tool, kg"][0] == "1.5"
    assert rows["largest grip force, N"][0] == "40"
    assert rows["box of the tool centre point, m"][0] == "x 0.15 to 0.7, y -0.55 to 0.5, z 0.25 to 1"
    assert printed()["payload beyond the tool, kg"][0] == "not stated"


def test_capsules_are_counted_by_the_link_that_carries_them():
    own = "{start_m=[0,0,0], end_m=[0,0.3,0.4], radius_m=0.1}, {start_m=[0,0,0], end_m=[0,0,0.1], radius_m=0.2}"
    cable = "{link='forearm', start_m=[0,0,0], end_m=[0,0,0.1], radius_m=0.05}"
    rows = printed(f"robot.capsules=[{own}, {cable}]")
    assert rows["capsules on tool0"] == ["2, up to 600 mm from its origin", "robot.capsules"]
    assert rows["capsules on forearm"][0] == "1, up to 150 mm from its origin"
    assert printed("robot.capsules=[]")["capsules around the tool"][0] == "none: a bare flange"


def test_the_effort_of_each_joint_is_the_files(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text((ARMS / "offset_wrist.urdf").read_text().replace('effort="150"', 'effort="77"'))
    rows = printed(f"robot.model={urdf}", "robot.acceleration_rad_s2=[10.0]")
    assert "77" in rows["effort, N m"]
    assert "150" not in rows["effort, N m"]


def test_what_is_refused_is_printed_before():
    done = CliRunner().invoke(app, ["limits", "--set", "robot.jerk_rad_s3=1"])
    assert isinstance(done.exception, ConfigError)
    assert "may take 7090 ms to stop" in str(done.exception)
    assert rows_of(done.output)["longest stop, ms"][0] == "7090"


def test_the_longest_stop_is_the_one_from_full_speed():
    rows = printed()
    assert rows["longest stop, ms"][0] == "334"
    assert rows["3.14 rad/s, full speed"][2] == "334 ms"
    assert rows["100 ms"][1] == f"{100 + 8 + 334} ms"


@pytest.mark.parametrize(
    ("speed", "names"), [(0.2, ["0.5 rad/s", "0.628 rad/s, full speed"]), (0.1, ["0.314 rad/s, full speed"])]
)
def test_a_speed_beyond_the_arms_own_has_no_row(speed, names):
    rows = printed(f"robot.speed={speed}")
    assert [name for name in rows if "rad/s" in name and name[0].isdigit()] == names
