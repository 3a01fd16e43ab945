"""What the other site, a driver or an operator says does nothing to the terminal of who reads it."""

import re
import sys
from collections.abc import Callable
from io import StringIO

import pytest
from msgspec.structs import replace
from rich.console import Console

from common.errors import ConfigError, FarhandError, RefusedError, TransportError
from common.geometry import Array
from farhand.cli import main
from farhand.doctor.findings import as_text, warning
from farhand.exits import NOT_STOPPED
from farhand.loopback.display import LiveSummary, print_table
from farhand.loopback.measured_run import LoopbackOperator, run_figures
from farhand.loopback.recorder import CameraRecord, Record
from farhand.terminal import complain, progress_bar, say
from remote_site.config import RemoteConfig
from remote_site.drivers.conformance.verdicts import Verdict
from tests.common.messages.golden_examples import HAND, STATE

SAID = "no \x1b[31m\x07\r\u202eredro [/nothing] \nfarhand: engaged"
SHOWN = r"no \x1b[31m\x07\r\u202eredro [/nothing] \nfarhand: engaged"
REQUESTS = {
    ("engage",): "farhand.authority.engage.request_engage",
    ("maintenance", "stop"): "farhand.authority.engage.request_maintenance",
    ("lease", "release"): "farhand.authority.lease.act_on_lease",
}


def answer(_request: object = None, *_others: object) -> str:
    return SAID


def refuse(*_request: object) -> str:
    raise TransportError(SAID)


def run(command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["farhand", *command])
    with pytest.raises(SystemExit):
        main()


class NobodyOperates(LoopbackOperator):
    """No hand, no gripper."""

    def __init__(self) -> None:
        """Of nobody."""

    def openings(self, _now_ns: int) -> int:
        """None."""
        return 0

    def truth(self, _t_ns: int) -> dict[str, Array]:
        """Of nothing."""
        return {}


@pytest.mark.parametrize("command", REQUESTS)
def test_an_answer_is_one_harmless_line(
    command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(REQUESTS[command], answer)
    run(command, monkeypatch)
    assert capsys.readouterr().out == f"{SHOWN}\n"


@pytest.mark.parametrize("command", REQUESTS)
def test_a_refusal_is_one_harmless_line(
    command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(REQUESTS[command], refuse)
    run(command, monkeypatch)
    before = f"{NOT_STOPPED} " if command == ("maintenance", "stop") else ""
    assert capsys.readouterr().err == f"farhand: {before}{SHOWN}\n"


def test_a_driver_under_test_says_harmless_lines(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def test_driver(config: object, report: Callable[[str], None], should_stop: object) -> dict[str, Verdict]:
        assert config is not None
        assert should_stop is not None
        report(SAID)
        return {"rests": Verdict.PASSED}

    monkeypatch.setattr("remote_site.runtime.conformance.test_driver", test_driver)
    run(("driver", "test", "kinematic"), monkeypatch)
    assert capsys.readouterr().out == f"{SHOWN}\n"


def test_the_lease_is_shown_a_line_for_each_fact(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    spoken = replace(STATE, readiness=replace(STATE.readiness, reason=SAID))
    monkeypatch.setattr("farhand.authority.lease.seen_state", lambda *_: spoken)
    run(("lease", "show"), monkeypatch)
    assert capsys.readouterr().out.splitlines()[-1].endswith(SHOWN)


@pytest.mark.parametrize(
    ("error", "lines"),
    [(ConfigError("one\ntwo\x1b"), ["farhand: one", r"two\x1b"]), (RefusedError("one\ntwo"), [r"farhand: one\ntwo"])],
)
def test_a_list_of_mistakes_keeps_its_lines(
    error: FarhandError, lines: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    complain(error)
    assert capsys.readouterr().err.splitlines() == lines


def test_a_finding_is_harmless() -> None:
    lines = as_text([warning("link", SAID, SAID)]).splitlines()
    assert lines[:2] == [f"warning  link: {SHOWN}", f"           cure: {SHOWN}"]


def test_a_run_of_both_sites_shows_every_word_of_theirs(capsys: pytest.CaptureFixture[str]) -> None:
    record = Record()
    record.states.append(replace(STATE, reason=SAID))
    record.hands.append(HAND)
    with LiveSummary(1.0) as live:
        live.print(SAID)
        live.show(0.5, record)
    told = capsys.readouterr().err
    assert SHOWN in told
    assert not set(told) & set("\x1b\x07\u202e")


def test_the_line_of_a_run_fits_a_terminal_with_its_bar_and_its_time(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")  # rich's word for a terminal
    monkeypatch.setenv("TERM", "xterm")
    record = Record()
    record.states.append(replace(STATE, reason="the arm waits for the hand, " * 9))
    record.hands.append(HAND)
    with LiveSummary(30.0) as live:
        live.show(4.0, record)
    lines = [re.sub(r"\x1b\[[?\d;]*[A-Za-z]", "", line) for line in re.split(r"[\r\n]", capsys.readouterr().err)]
    assert max(map(len, lines)) <= 80
    last = [line for line in lines if line.strip()][-1]
    assert last.startswith("engaged, hand tracked")
    assert last.endswith("0:00:00")
    assert "━" in last


def test_a_bar_is_on_standard_error_and_nothing_is_where_no_work_was_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with progress_bar():
        pass
    assert capsys.readouterr() == ("", "")
    with progress_bar() as show:
        show("links covered", 3, 4)
    out, err = capsys.readouterr()
    assert out == ""
    assert "links covered" in err
    assert "3/4" in err


def test_what_is_said_is_said_as_it_is_where_nothing_is_hidden(capsys: pytest.CaptureFixture[str]) -> None:
    say("the arm follows the hand – 40 °")
    assert capsys.readouterr().out == "the arm follows the hand – 40 °\n"


def test_the_name_of_a_recording_is_no_markup_in_a_bar(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar() as show:
        show(SAID, 1, 2)
        show(SAID, 2, 2)
    assert SHOWN in capsys.readouterr().err


def test_the_name_of_a_camera_is_no_markup_in_the_loopbacks_table() -> None:
    printed = StringIO()
    record = Record(cameras={SAID: CameraRecord()})
    figures = run_figures(record, NobodyOperates(), RemoteConfig(), []) | {"too_slow": None, "slow_views": None}
    print_table(figures, Console(file=printed, width=200))
    assert f"camera {SHOWN}" in printed.getvalue()
