"""Pace of a live trial: its outcome, and whether the machine kept up with it, from what was recorded; pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from common.clock import NS_PER_S
from common.messages.hand import HandArm, TrackingStatus
from common.messages.robot import RobotState, SessionState
from farhand.loopback.figures import latency_figures
from farhand.loopback.recorder import Record
from lab.experiments.placing.live.judgement import TrialJudgement
from lab.experiments.placing.trial import TrialResult
from lab.visual_operator.at_console.operator_process import TrialNotes

LOST_TIME = "simulated cell lost time"


@dataclass(frozen=True, slots=True)
class Pace:
    """The pace of the machine in one trial: whether it kept up.

    Of control's `periods`, `missed` were. `cell_late` is how often the simulated cell gave time up, `hand_late` how
    often the operator's hand stood still because its process came late. Hand samples came `hands_per_s`, and `lost`
    of them saw no hand; a command came `command_ms` after its exposure. The operator looked `looks_per_s`, at
    pictures `picture_age_ms` old, for `look_ms` each. Times are medians. `reasons` are how often it saw which reason
    of the session's state.
    """

    periods: int
    missed: int
    cell_late: int
    hand_late: int
    hands_per_s: float
    lost: int
    command_ms: float
    picture_age_ms: float
    looks_per_s: float
    look_ms: float
    reasons: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class LiveResult:
    """A trial, and how the machine did in it."""

    trial: TrialResult
    pace: Pace


def live_result(notes: TrialNotes, judgement: TrialJudgement, record: Record, events: Sequence[str]) -> LiveResult:
    """Sum up what was recorded of a trial, from its begin to its end; `events` are the processes' warnings."""
    states = [state for state in record.states if notes.start_ns <= state.t_ns <= notes.end_ns]
    hands = [hand for hand in record.hands if notes.start_ns <= hand.capture_ns <= notes.end_ns]
    trial = TrialResult(
        judgement.end,
        notes.time_s,
        judgement.drops,
        judgement.collisions,
        notes.clutches,
        notes.misses,
        sum(now.state is SessionState.HOLDING is not before.state for before, now in pairwise(states)),
        judgement.grip_force_n,
        _median(notes.ages_ms),
    )
    return LiveResult(trial, _pace(notes, states, hands, sum(LOST_TIME in event for event in events)))


def _pace(notes: TrialNotes, states: Sequence[RobotState], hands: Sequence[HandArm], cell_late: int) -> Pace:
    first, last = (states[k].timing for k in (0, -1))
    command_ms = latency_figures(states)["capture_to_command_ms"]["p50"]
    return Pace(
        periods=last.ticks - first.ticks,
        missed=last.missed - first.missed,
        cell_late=cell_late,
        hand_late=notes.late,
        hands_per_s=(len(hands) - 1) * NS_PER_S / (hands[-1].capture_ns - hands[0].capture_ns),
        lost=sum(hand.status is TrackingStatus.LOST for hand in hands),
        command_ms=command_ms if command_ms is not None else float("nan"),
        picture_age_ms=_median(notes.ages_ms),
        looks_per_s=len(notes.ages_ms) / notes.time_s,
        look_ms=_median(notes.looks_ms),
        reasons=notes.reasons,
    )


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")
