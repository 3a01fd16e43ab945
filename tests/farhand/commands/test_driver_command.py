"""How `farhand driver test` ends: 1 where a check failed, 3 where none did but some have to be repeated."""

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence

import pytest
import structlog

from common.config.loading import load_config
from common.process.log import finish_log
from common.process.service import StopFlag
from farhand.cli import main
from remote_site.config import RemoteConfig
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.conformance.verdicts import Verdict
from remote_site.runtime import conformance

PASSED, SKIPPED, FAILED, REPEAT, SUFFERS = Verdict


@pytest.mark.parametrize(
    ("verdicts", "code"),
    [
        ([PASSED, SKIPPED], 0),
        ([PASSED, FAILED, SUFFERS], 1),
        ([PASSED, REPEAT], 3),
        ([REPEAT, FAILED], 1),
    ],
)
def test_the_exit_code_tells_what_failed_from_what_nothing_is_known_of(
    verdicts: Sequence[Verdict], code: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conformance, "test_driver", lambda *_: dict(enumerate(verdicts)))
    monkeypatch.setattr(sys, "argv", ["farhand", "driver", "test", "kinematic"])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == code


@pytest.fixture
def _left_as_it_was() -> Iterator[None]:
    yield
    finish_log()
    structlog.reset_defaults()


@pytest.mark.slow
@pytest.mark.usefixtures("_left_as_it_was")
@pytest.mark.parametrize(
    ("verdicts", "summary"),
    [
        ([PASSED, SKIPPED], "kinematic: all passed"),
        ([FAILED, SUFFERS, SUFFERS], "kinematic: 1 failed"),
        ([PASSED, REPEAT, REPEAT], "kinematic: none failed, 2 to be repeated, because this machine stood still"),
        ([FAILED, REPEAT], "kinematic: 1 failed, 1 to be repeated, because this machine stood still"),
    ],
)
def test_the_last_line_counts_both(verdicts: Sequence[Verdict], summary: str, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[DriverStand] = []

    def verdicts_of(stand: DriverStand, _report: Callable[[str], None]) -> dict[str, Verdict]:
        seen.append(stand)
        with stand.measure_pauses() as meter:  # of this thread, and of the process that sleeps and wakes
            assert len(meter.read().watched_ns) == 1
        return {str(k): verdict for k, verdict in enumerate(verdicts)}

    lines: list[str] = []
    monkeypatch.setattr(conformance, "verdicts_of", verdicts_of)
    monkeypatch.setattr(conformance, "ask_for_real_time", lambda _: True)
    conformance.test_driver(load_config(RemoteConfig, None, ["driver.name=kinematic"]), lines.append, StopFlag())
    assert seen
    assert lines[-1] == summary


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_suite_in_order_once_the_robot_rests(number: signal.Signals) -> None:
    command = [sys.executable, "-m", "farhand", "driver", "test", "kinematic"]
    suite = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert suite.stdout is not None
    assert suite.stdout.readline().startswith("passed")
    suite.send_signal(number)
    _, said = suite.communicate(timeout=60)
    assert suite.returncode == 130
    assert said.splitlines()[-1] == "farhand: interrupted; the robot was stopped and let go of"
    assert "leaked" not in said
