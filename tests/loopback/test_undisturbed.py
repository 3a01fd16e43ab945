"""The machine's pauses are told from all else that ends an engagement, by the reasons that the session really gives."""

import json
from pathlib import Path

import pytest

from common.messages.robot import SessionState
from remote_site.reasons import Code, reason
from tests.late_machine import was_late
from tests.loopback.undisturbed import RUNS, undisturbed
from tests.remote_site.remote_loop import RemoteLoop

STALE = reason(Code.STALE, age_ms=1003, limit_ms=1000).sentence
UNSTEADY = reason(Code.UNSTEADY, held_ms=900, least_ms=1000).sentence
LOST = reason(Code.LOST, reason="as scripted").sentence


@pytest.mark.parametrize(
    ("cause", "is_late"),
    [
        (STALE, True),
        (reason(Code.HELD_TOO_LONG, limit_ms=2000, cause=UNSTEADY).sentence, True),
        (reason(Code.PAUSED, paused_ms=700, limit_ms=400).sentence, True),
        (LOST, False),
        (reason(Code.JUMPS, point="wrist", count=3).sentence, False),
    ],
)
def test_a_late_machine_is_known_by_the_reason(cause: str, *, is_late: bool) -> None:
    assert was_late(reason(Code.LATCHED, cause=cause).sentence) is is_late


def test_an_arm_that_waits_has_not_been_ended_by_the_machine() -> None:
    assert not was_late(STALE)


def test_silence_of_a_second_ends_an_engagement_with_such_a_reason() -> None:
    loop = RemoteLoop()
    loop.run(500, lambda _t_ns: (0.0, 0.0, 0.3))
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(300)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert was_late(loop.snapshot.reason.sentence)


def test_a_run_that_the_machine_has_ended_is_made_again_a_few_times(tmp_path: Path) -> None:
    report, late = tmp_path / "out.json", f"3.1 s: disengaged, {reason(Code.LATCHED, cause=STALE).sentence}"
    for disturbed, runs in ((0, 1), (2, 3), (9, RUNS)):
        made: list[int] = []

        def run(disturbed: int = disturbed, made: list[int] = made) -> None:
            made.append(1)
            report.write_text(json.dumps({"events": [late] if len(made) <= disturbed else []}))

        undisturbed(run, report)
        assert len(made) == runs
