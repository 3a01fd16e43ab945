"""What a person at a terminal asks of running sites: their status, to disengage, to stop."""

import subprocess
import sys

import pytest

from common.messages.robot import STOPPED, SessionState
from common.messages.video import CameraStatus
from tests.integration.pair import OPERATOR, Pair
from tests.integration.sites import CELL, Sites

CAMERAS = {"camera front_high", "camera front_low", "camera side", "camera gripper"}


def farhand(*arguments: str, sites: Sites) -> subprocess.CompletedProcess[str]:
    """A command that asks the remote site of these."""
    command = [sys.executable, "-m", "farhand", *arguments, "--cell", CELL, "--remote", sites.endpoints.control]
    return subprocess.run(command, check=False, capture_output=True, text=True, timeout=120)


@pytest.mark.slow
def test_a_running_cell_is_shown_disengaged_and_stopped_from_a_terminal(pair: Pair) -> None:
    pair.following()
    sites = pair.sites

    shown = farhand("status", "--video", sites.endpoints.video, sites=sites)
    assert shown.returncode == 0, shown.stderr
    rows = dict(line.split(": ", 1) for line in shown.stdout.splitlines())
    assert {"state", "hand samples", "hand age", "obeyed", "round trip", "control", "states", "recorder"} <= set(rows)
    assert rows["lease"].startswith(f"{OPERATOR} (site ")
    assert set(rows) >= CAMERAS
    assert {rows[name].partition(",")[0] for name in CAMERAS} <= set(CameraStatus)
    assert rows["cell"] == f"{CELL} at {sites.endpoints.control}, robot a465, driver kinematic"
    unseen = farhand("status", "--once", "--no-pictures", sites=sites)
    assert "pictures: not counted, as asked" in unseen.stdout.splitlines()

    pair.following()
    disengaged = farhand("disengage", "--operator", OPERATOR, sites=sites)
    assert disengaged.stdout == "disengaged on request\n"
    sites.wait("the arm to be disengaged", lambda: sites.is_in(SessionState.DISENGAGED))

    stopped = farhand("stop", "--operator", "somebody", sites=sites)
    assert (stopped.returncode, stopped.stderr) == (0, "")
    assert stopped.stdout.endswith(
        "ms: stopped by somebody; reset it, then engage (farhand reset, or Reset on the page)\n"
    )
    sites.wait("the state to say so", lambda: sites.state.code == STOPPED)
    barred = farhand("engage", "--operator", OPERATOR, sites=sites)
    assert barred.returncode == 1
    assert "reset it, then engage (farhand reset, or Reset on the page)" in barred.stderr
    reset = farhand("reset", "--operator", OPERATOR, sites=sites)
    cleared = "to reset: stopped by somebody; reset it, then engage\nreset; engage to continue\n"
    assert (reset.returncode, reset.stdout) == (0, cleared), reset.stderr
    reset = farhand("maintenance", "reset", sites=sites)
    assert reset.returncode == 0, reset.stderr
