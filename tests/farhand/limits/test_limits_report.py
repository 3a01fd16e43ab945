"""What `farhand limits` prints: the limits with their sources, and the stops, as docs/safety.md quotes them."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from common.errors import ConfigError
from farhand.cli import app
from tests.remote_site.arms_followed import ARMS

DOCUMENT = Path(__file__).parents[3] / "docs" / "safety.md"
BEGIN, END = "<!-- what farhand limits prints -->\n\n", "\n<!-- as far as here -->"


def printed(*settings: str) -> dict[str, list[str]]:
    """The rows of all tables by their first cell."""
    done = CliRunner().invoke(app, ["limits", *(part for setting in settings for part in ("--set", setting))])
    assert done.exit_code == 0, done.exception
    lines = [line.strip("|").split("|") for line in done.output.splitlines() if line.startswith("|")]
    return {cells[0].strip(): [cell.strip() for cell in cells[1:]] for cells in lines}


def test_the_document_quotes_what_it_prints_for_the_shipped_configuration():
    done = CliRunner().invoke(app, ["limits"])
    quoted = DOCUMENT.read_text(encoding="utf-8").split(BEGIN)[1].split(END)[0]
    assert done.output == quoted


def test_a_file_is_read_and_its_limits_are_named_as_its_own(tmp_path):
    file = tmp_path / "remote.toml"
    file.write_text(
        "[robot]\nspeed = 0.5\njerk_rad_s3 = 400.0\nposition_deg = { joint_2 = [-60.0, 45.0] }\n"
        "[safety]\nt_soft_ms = 200.0\n"
    )
    done = CliRunner().invoke(app, ["limits", "--config", str(file)])
    assert "| 1.57 | 1.57 | 1.57 | 1.49 | 1.51 | 1.49 | robot.speed = 0.5 of the arm's file |" in done.output
    assert "robot.jerk_rad_s3; the arm's file allows 1000 |" in done.output
    assert "robot.position_deg for joint_2, else the arm's file, less robot.position_margin_deg = 1 |" in done.output
    ages = done.output.split("From the exposure")[1]
    assert "| 200 ms | 0.785 rad/s |" in ages
    assert ages.count(" rad/s |") == 1


def test_an_arm_whose_file_states_little_is_said_to_do_so(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text((ARMS / "offset_wrist.urdf").read_text().replace(' jerk="1000"', ""))
    rows = printed(f"robot.model={urdf}", "robot.acceleration_rad_s2=[10.0]")
    assert rows["jerk, rad/s³"][-1] == "100 where the arm's file states none"
    assert rows["acceleration, rad/s²"][-1] == "robot.acceleration_rad_s2; the arm's file states none"


def test_what_is_refused_is_printed_before():
    done = CliRunner().invoke(app, ["limits", "--set", "robot.jerk_rad_s3=1"])
    assert isinstance(done.exception, ConfigError)
    assert "may take 7090 ms to stop" in str(done.exception)
    assert "| longest stop, ms | 7090 |" in done.output


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
