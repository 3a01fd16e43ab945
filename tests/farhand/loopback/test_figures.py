"""The loopback's figures from made-up records whose figures are known."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from common.errors import ConfigError
from common.messages.hand import HandArm, TrackingStatus
from common.messages.robot import (
    Engagement,
    GripperCommand,
    HandLink,
    LoopTiming,
    Obeyed,
    Pose,
    Readiness,
    RobotState,
    SessionState,
    Traced,
)
from farhand.loopback.figures import (
    Expectation,
    control_figures,
    follow_figures,
    latency_figures,
    session_events,
    trace_figures,
    tracking_figures,
    troubles,
)
from farhand.loopback.measured_run import write_report
from farhand.loopback.recorder import CameraRecord
from tests.common.messages.golden_examples import HAND

MS = 1_000_000
ROTATION = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
ORIGIN = Pose((0.4, 0.0, 0.8), (0.0, 0.0, 0.0, 1.0))


def truth(t_ns: int) -> dict[str, np.ndarray]:
    """A wrist on a circle of 0.1 m, once in four seconds."""
    angle = 2 * np.pi * t_ns / 4e9
    wrist = np.array([0.1 * np.cos(angle), 0.1 * np.sin(angle), 0.3])
    return {"wrist": wrist, "elbow": wrist, "index": wrist, "thumb": wrist}


def state(t_ns: int, tool: np.ndarray, obeyed: Obeyed | None = None) -> RobotState:
    return RobotState(
        session=1,
        seq=t_ns // MS,
        t_ns=t_ns,
        state=SessionState.ENGAGED,
        code="ok",
        reason="",
        q=(),
        q_commanded=(),
        base_T_tool=Pose(tuple(tool), (0.0, 0.0, 0.0, 1.0)),
        gripper=None,
        gripper_toggles_applied=0,
        gripper_next=GripperCommand.CLOSED,
        obeyed=obeyed,
        engagement=Engagement(1, 2000 * MS, ORIGIN),
        rejected={},
        age_limit_ms=100.0,
        speed_scale=1.0,
        timing=LoopTiming(hz=250.0, late_p99_us=80.0, missed=5, ticks=1000, real_time=True),
        lease=None,
        clock=None,
        readiness=Readiness(ready=True, code="ok", reason="", held=False),
    )


def hand(t_ns: int, offset: float, status: TrackingStatus = TrackingStatus.TRACKED) -> HandArm:
    wrist = tuple(truth(t_ns)["wrist"] + np.array([offset, 0, 0])) if status is not TrackingStatus.LOST else None
    return HandArm(
        session=1,
        seq=t_ns // MS,
        capture_ns=t_ns,
        elbow=None,
        wrist=wrist,
        index=None,
        thumb=None,
        status=status,
        reason="",
        thumb_inferred=False,
        hand_open=False,
        gripper_toggles=0,
    )


@pytest.mark.parametrize("lag_ms", [0, 60, 150, 800])
def test_the_lag_is_found_and_what_remains_is_the_error(lag_ms: int) -> None:
    offset = np.array([0.0, 0.0, 0.004])
    origin = np.array(ORIGIN.position)
    states = [
        state(t, origin + ROTATION @ (truth(t - lag_ms * MS)["wrist"] - truth(2000 * MS)["wrist"]) + offset)
        for t in range(3000 * MS, 7000 * MS, 20 * MS)
    ]
    figures = follow_figures(states, truth, Expectation(1.0, ROTATION))
    assert figures["follow_lag_ms"] == pytest.approx(lag_ms, abs=2)
    assert figures["follow_mm"]["mean"] == pytest.approx(4.0, abs=0.05)


def test_a_tool_that_stands_still_does_not_follow() -> None:
    states = [state(t, np.array(ORIGIN.position)) for t in range(3000 * MS, 7000 * MS, 20 * MS)]
    assert follow_figures(states, truth, Expectation(1.0, ROTATION))["follow_mm"]["mean"] > 50


def test_without_engagement_there_is_no_figure() -> None:
    assert follow_figures([], truth, Expectation(1.0, ROTATION))["follow_mm"]["mean"] is None


def test_each_sample_counts_once_in_the_latency_with_its_last_word() -> None:
    obeyed = [Obeyed(1, k, k * 100 * MS, k * 100 * MS + 20 * MS, None) for k in range(10)]
    moved = [Obeyed(o.session, o.seq, o.capture_ns, o.command_ns, o.command_ns + 4 * MS) for o in obeyed]
    states = [state(o.command_ns, np.zeros(3), o) for pair in zip(obeyed, moved, strict=True) for o in pair]
    figures = latency_figures(states)
    assert figures["capture_to_command_ms"] == {"p50": 20.0, "p95": 20.0, "p99": 20.0}
    assert figures["capture_to_motion_ms"]["p50"] == 24.0
    assert figures["picture_to_command_ms"]["p50"] is None


def test_the_way_from_the_pictures_to_the_command_leaves_out_how_they_were_taken() -> None:
    obeyed = [Obeyed(1, k, k * 100 * MS, k * 100 * MS + 20 * MS, None) for k in range(10)]
    read = [
        msgspec.structs.replace(HAND, session=1, seq=k, capture_ns=k * 100 * MS, read_ns=k * 100 * MS + 13 * MS)
        for k in range(10)
    ]
    figures = latency_figures(
        [state(o.command_ns, np.zeros(3), o) for o in obeyed], [*read, msgspec.structs.replace(HAND, seq=99)]
    )
    assert figures["picture_to_command_ms"] == {"p50": 7.0, "p95": 7.0, "p99": 7.0}


def test_a_sample_is_followed_to_the_first_picture_taken_after_the_encoders_showed_it() -> None:
    shown = Traced(1, 5, 100 * MS, 120 * MS, 124 * MS, 150 * MS)
    later = Traced(1, 6, 133 * MS, 153 * MS, 157 * MS, 190 * MS)
    states = [msgspec.structs.replace(state(t * MS, np.zeros(3)), traced=shown) for t in (160, 180)]
    states.append(msgspec.structs.replace(state(200 * MS, np.zeros(3)), traced=later))
    front = CameraRecord(exposures_ns=[149 * MS, 182 * MS], arrivals_ns=[170 * MS, 203 * MS])
    side = CameraRecord(exposures_ns=[133 * MS, 166 * MS], arrivals_ns=[155 * MS, 190 * MS])
    figures = trace_figures(states, {"front": front, "side": side})
    way = {"seq": 5, "command": 20.0, "motion": 24.0, "encoder": 50.0, "picture": 66.0, "viewer": 90.0}
    assert figures["traces"] == [way]
    assert figures["trace_ms"]["viewer"] == {"p50": 90.0, "p95": 90.0}
    assert trace_figures(states[:2], {})["trace_ms"]["encoder"] == {"p50": None, "p95": None}


def test_tracking_counts_the_lost_and_measures_the_rest() -> None:
    hands = [hand(0, 0.0, TrackingStatus.INITIALISING), hand(33 * MS, 0.003), hand(66 * MS, 0.005)]
    figures = tracking_figures([*hands, hand(100 * MS, 0.0, TrackingStatus.LOST)], truth)
    assert (figures["frames"], figures["lost"]) == (3, 1)
    assert figures["error_mm"]["wrist"] == {"mean": 4.0, "max": 5.0}
    assert figures["error_mm"]["elbow"] == {"mean": None, "max": None}
    assert figures["fps"] == pytest.approx(30.0, rel=0.02)


def test_the_control_figures_are_the_last_ones() -> None:
    assert control_figures([state(MS, np.zeros(3))])["missed_share"] == 0.005
    assert control_figures([])["hz"] is None


def test_the_events_are_the_changes_of_the_session_since_it_first_followed():
    course = ["disengaged", "engaged", "engaged", "holding", "engaged"]
    states = [
        msgspec.structs.replace(state(500 * k * MS, np.zeros(3)), state=SessionState(name), reason=f"reason {k}")
        for k, name in enumerate(course)
    ]
    assert session_events(states) == ["1.0 s: holding, reason 3", "1.5 s: engaged, reason 4"]
    assert session_events(states[:1]) == []


def test_a_report_that_finds_no_room_is_reported():
    with pytest.raises(ConfigError, match="/dev/full: No space left on device; choose another file"):
        write_report(Path("/dev/full"), {})


def lacking(t_ns: int, code: str, reason: str) -> RobotState:
    """A state that waits, with an engagement that lacks something."""
    readiness = Readiness(ready=not reason, code=code, reason=reason, held=False)
    return msgspec.structs.replace(state(t_ns, np.zeros(3)), readiness=readiness, reason="waiting")


def test_what_lasted_is_told_and_not_what_was_at_the_last_moment() -> None:
    states = [lacking(k * 100 * MS, "starting", "the site starts") for k in range(100)]
    for k in range(100, 160):
        codes = ("lost", "a picture each 125 ms") if k % 3 else ("collecting", "1 of 30 good")
        states.append(lacking(k * 100 * MS, *codes))
    states.append(lacking(16_000 * MS, "collecting", "2 of 30 good"))
    assert troubles(states) == ["a picture each 125 ms"]
    figures = dict.fromkeys(
        ("age_ms", "network_ms", "clock_ms", "tracking_ms", "interval_ms", "jitter_ms", "loss"), 1.0
    )
    link = HandLink(**figures, code="samples_old", reason="too old")
    states[-2] = msgspec.structs.replace(states[-2], hand_link=link)
    assert troubles(states) == ["a picture each 125 ms", "too old"]


def test_without_anything_that_lasted_the_newest_reason_is_told() -> None:
    assert troubles([]) == []
    assert troubles([lacking(0, "collecting", "1 of 30 good"), lacking(MS, "ok", "")]) == ["waiting"]
