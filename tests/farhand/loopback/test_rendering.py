"""A run that fails where nothing can be rendered ends with what to install; any other failure is its own."""

import sys

import pytest

import farhand.cli
from common.errors import ProcessError
from farhand.loopback import measured_run, verdict
from farhand.loopback.verdict import explained, rendering_problem
from remote_site.video.cell_cameras import CURE

FAILURE = ProcessError("the remote process ended (exit code 1): process video died")


def test_without_egl_the_last_line_names_the_packages(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Failing:
        views_are_simulated = True

        def __init__(self, *_: object) -> None:
            pass

        def run(self) -> None:
            sys.stderr.write("a table and a log\n")
            raise FAILURE

    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    monkeypatch.setattr(measured_run, "Loopback", Failing)
    monkeypatch.setattr(sys, "argv", ["farhand", "loopback"])
    with pytest.raises(SystemExit) as ended:
        farhand.cli.main()
    assert ended.value.code == 1
    *_, why, packages = capsys.readouterr().err.splitlines()
    assert why.startswith("farhand: broken: simulated views need EGL")
    assert packages == f"install what is missing, {CURE}"
    assert "libegl1" in CURE


def test_without_mujoco_the_last_line_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert rendering_problem().splitlines()[-1] == "install it: pip install 'farhand[sim]'"


def test_a_failure_of_another_kind_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verdict, "rendering_problem", lambda: "")
    assert explained(FAILURE, views_are_simulated=True) is FAILURE
    monkeypatch.setattr(verdict, "rendering_problem", lambda: pytest.fail("real cameras need no EGL"))
    assert explained(FAILURE, views_are_simulated=False) is FAILURE
