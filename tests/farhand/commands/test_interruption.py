"""A person's Ctrl-C ends a run in order: what was measured is kept, and nothing is reported as a failure."""

import json

import pytest

import farhand.cli
from common.errors import InterruptionError, ProcessError
from common.process.service import StopFlag
from farhand.loopback import measured_run as loopback
from farhand.loopback.measured_run import run_loopback
from farhand.loopback.plan import LoopbackOptions
from farhand.loopback.recorder import Record

SLOW = "this machine was too slow: the tracking was late"


def figures(engagements, mean):
    return {
        "engagements": engagements,
        "follow_mm": {"mean": mean},
        "stopped": None,
        "followed_share": 0.973,
        "too_slow": None,
        "slow_views": None,
        "capture_to_command_ms": {"p50": 13.2},
    }


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Runs a loopback that gives these figures, asked to stop or not; gives the report."""

    def run(given, *, seconds, interrupted):
        class Done:
            operator_views = ()
            record = Record()
            failure = None

            def __init__(self, *_):
                pass

            def run(self):
                return given

        monkeypatch.setattr(loopback, "Loopback", Done)
        monkeypatch.setattr(loopback, "print_table", lambda *_: None)
        should_stop = StopFlag()
        if interrupted:
            should_stop.set()
        run_loopback(LoopbackOptions(seconds, tmp_path / "out.json"), should_stop)

    return run


@pytest.mark.parametrize(("engagements", "mean"), [(0, None), (1, 400.0), (1, 5.0)])
def test_an_interrupted_run_is_told_as_such_whatever_it_measured(run, tmp_path, engagements, mean):
    with pytest.raises(InterruptionError, match="interrupted"):
        run(figures(engagements, mean), seconds=30.0, interrupted=True)
    assert json.loads((tmp_path / "out.json").read_text())["engagements"] == engagements


def test_an_endless_run_that_a_person_ends_is_done_once_the_arm_has_followed(run):
    run(figures(1, 5.0), seconds=0.0, interrupted=True)
    with pytest.raises(InterruptionError):
        run(figures(0, None), seconds=0.0, interrupted=True)


def test_an_arm_that_did_not_follow_is_a_failure_still(run):
    with pytest.raises(ProcessError, match=r"^broken: the arm was never engaged$"):
        run(figures(0, None), seconds=30.0, interrupted=False)


def test_the_last_line_says_good_or_too_slow(run, capsys):
    run(figures(1, 4.44), seconds=30.0, interrupted=False)
    assert capsys.readouterr().out == (
        "good: the arm followed for 97.3% of the time, 4.4 mm off the hand, 13 ms from exposure to command\n"
    )
    few = "but it was too slow for the views: side 4 of 30 pictures a second"
    run(figures(1, 4.44) | {"slow_views": few}, seconds=30.0, interrupted=False)
    assert capsys.readouterr().out.endswith(f"from exposure to command; {few}\n")
    run(figures(1, 4.44) | {"too_slow": SLOW}, seconds=30.0, interrupted=False)
    assert capsys.readouterr().out == f"{SLOW}\n"


def test_a_failure_of_a_machine_that_is_too_slow_is_not_called_broken(run):
    with pytest.raises(ProcessError, match=rf"^the arm was never engaged\n{SLOW}$"):
        run(figures(0, None) | {"too_slow": SLOW}, seconds=30.0, interrupted=False)


def test_an_interruption_has_an_exit_code_of_its_own(monkeypatch, capsys):
    def interrupted(**_):
        raise InterruptionError("interrupted")

    monkeypatch.setattr(farhand.cli, "app", interrupted)
    with pytest.raises(SystemExit) as ended:
        farhand.cli.main()
    assert ended.value.code == 130
    assert capsys.readouterr().err == "farhand: interrupted\n"
