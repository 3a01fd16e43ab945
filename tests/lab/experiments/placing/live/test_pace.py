"""What a live trial came to and whether the machine kept up, from a made-up record whose figures are known."""

import pytest
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import TrackingStatus
from common.messages.robot import LoopTiming, Obeyed, SessionState
from farhand.loopback.recorder import Record
from lab.experiments.placing.judge import Placed
from lab.experiments.placing.live.judgement import TrialJudgement
from lab.experiments.placing.live.pace import LOST_TIME, live_result
from lab.measure.page import scene
from lab.visual_operator.at_console.operator_process import TrialNotes
from lab.visual_operator.operator import Notes

END = TrialJudgement(end=Placed(1.0, -2.0, 0.5, True), drops=1, collisions=2, grip_force_n=30.0)
BEGIN_S, END_S = 10, 20
HOLDS_AT_S = 12, 13, 15  # the first two are one hold


def state(t_s):
    timing = LoopTiming(250.0, 100.0, 5 + t_s // 4, 250 * t_s, True)
    exposed_ns = t_s * NS_PER_S
    word = SessionState.HOLDING if t_s in HOLDS_AT_S else SessionState.ENGAGED
    obeyed = Obeyed(7, t_s, exposed_ns, exposed_ns + 20 * NS_PER_MS, None)
    return scene.state(word, "", "", t_ns=t_s * NS_PER_S, timing=timing, obeyed=obeyed)


def hand(t_s):
    status = TrackingStatus.LOST if t_s in (5, 14) else TrackingStatus.TRACKED
    return replace(scene.hand(), capture_ns=t_s * NS_PER_S, status=status)


@pytest.fixture
def result():
    notes = TrialNotes(start_ns=BEGIN_S * NS_PER_S)
    for age_ms, took_ms, code in ((60.0, 30.0, "ok"), (80.0, 50.0, "let_go"), (70.0, 40.0, "ok")):
        notes.add_look(age_ms, took_ms, code)
    notes.end(Notes(clutches=4, misses=1), END_S * NS_PER_S, 2)
    record = Record(hands=[hand(t_s) for t_s in range(30)], states=[state(t_s) for t_s in range(30)])
    return live_result(notes, END, record, ["a", f"remote: level=warning event={LOST_TIME!r} late_ms=50"])


def test_the_trial_is_told_as_a_stepped_one_is(result):
    trial = result.trial
    assert (trial.end, trial.drops, trial.collisions, trial.grip_force_n) == (END.end, 1, 2, 30.0)
    assert (trial.time_s, trial.clutches, trial.misses, trial.holds) == (10.0, 4, 1, 2)
    assert trial.picture_age_ms == 70.0


def test_the_pace_is_that_of_the_time_between_begin_and_end(result):
    pace = result.pace
    assert (pace.periods, pace.missed, pace.cell_late, pace.hand_late) == (2500, 3, 1, 2)
    assert (pace.hands_per_s, pace.lost, pace.command_ms) == (1.0, 1, 20.0)
    assert (pace.looks_per_s, pace.look_ms, pace.picture_age_ms) == (0.3, 40.0, 70.0)
    assert pace.reasons == {"ok": 2, "let_go": 1}
