"""What the page shows over time: latencies of the last minute, one sample's path, events, what was painted."""

import msgspec
import pytest

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate, ClockOffset
from common.messages.hand import ClockSync
from common.messages.robot import (
    GripperCommand,
    LoopTiming,
    Obeyed,
    Pose,
    Readiness,
    RobotState,
    SessionState,
    Traced,
)
from common.messages.video import CameraStatus, Codec, VideoFrame, ViewCame
from local_site.console.model.frames import LENGTH, view_frame
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.page_messages import Painted, Shown
from local_site.console.model.shown import ShownViews

APART_NS = 3600 * NS_PER_S
NOW_NS = 50 * NS_PER_S
LEASE = 77
STATE = RobotState(
    session=1,
    seq=1,
    t_ns=NOW_NS + APART_NS,
    state=SessionState.ENGAGED,
    code="ok",
    reason="the arm follows the hand",
    q=(0.0,),
    q_commanded=(0.0,),
    base_T_tool=Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)),
    gripper=None,
    gripper_toggles_applied=0,
    gripper_next=GripperCommand.CLOSED,
    obeyed=None,
    engagement=None,
    rejected={},
    age_limit_ms=100.0,
    speed_scale=1.0,
    timing=LoopTiming(250.0, 100.0, 0, 1, False),
    lease=None,
    clock=ClockSync(remote_minus_local_ns=APART_NS, uncertainty_ns=NS_PER_MS, measured_ns=0),
    readiness=Readiness(True, "ok", "", True),
)


def obeying(seq: int, exposed_ns: int, command_ms: float, motion_ms: float | None) -> RobotState:
    """A state that obeys a sample exposed at a time of the local clock, this many ms later."""
    command_ns = exposed_ns + APART_NS + round(command_ms * NS_PER_MS)
    motion_ns = None if motion_ms is None else command_ns + round(motion_ms * NS_PER_MS)
    return msgspec.structs.replace(STATE, obeyed=Obeyed(1, seq, exposed_ns, command_ns, motion_ns))


def test_a_sample_counts_once_by_the_clocks_offset() -> None:
    latencies = Latencies()
    for seq, command_ms in enumerate((20.0, 30.0, 40.0)):
        for motion_ms in (None, 5.0, 5.0):
            latencies.add_state(obeying(seq, NOW_NS, command_ms, motion_ms), NOW_NS)
    told = latencies.summary(NOW_NS)
    assert (told["command"]["count"], told["command"]["p50"], told["command"]["newest"]) == (3, 30.0, 40.0)
    assert (told["motion"]["count"], told["motion"]["p50"]) == (3, 5.0)


def test_without_a_clock_nothing_is_told() -> None:
    latencies = Latencies()
    latencies.add_state(msgspec.structs.replace(obeying(1, NOW_NS, 20.0, 5.0), clock=None), NOW_NS)
    assert latencies.summary(NOW_NS)["command"]["p50"] is None


def test_only_the_last_minute_counts_and_only_the_last_second_is_now() -> None:
    latencies = Latencies()
    latencies.add_clock(ClockEstimate(ClockOffset(0, 2 * NS_PER_MS), 0), 7.0, NOW_NS)
    assert latencies.summary(NOW_NS)["uncertainty"]["newest"] == 2.0
    later = latencies.summary(NOW_NS + 2 * NS_PER_S)["round_trip"]
    assert (later["newest"], later["p95"]) == (None, 7.0)
    assert latencies.summary(NOW_NS + 61 * NS_PER_S)["round_trip"]["count"] == 0


def test_the_hand_is_seen_in_the_first_picture_taken_after_the_encoders_showed_it() -> None:
    latencies = Latencies()
    moved_ns = NOW_NS + APART_NS + 50 * NS_PER_MS
    traced = Traced(1, 7, NOW_NS, moved_ns - 30 * NS_PER_MS, moved_ns - 20 * NS_PER_MS, moved_ns)
    for _ in range(3):
        latencies.add_state(msgspec.structs.replace(obeying(8, NOW_NS, 25.0, None), traced=traced), NOW_NS)
    told = latencies.summary(NOW_NS)["encoder"]
    assert (told["count"], told["newest"]) == (1, 30.0)
    latencies.painted("side", moved_ns - 1, 50.0, NOW_NS)
    assert latencies.trace is None
    for _ in range(3):  # reported again at 10 Hz
        latencies.painted("side", moved_ns + 15 * NS_PER_MS, 40.0, NOW_NS)
    trace = latencies.trace
    assert trace is not None
    assert (trace.seq, trace.command_ms, trace.motion_ms, trace.encoder_ms) == (7, 20.0, 30.0, 50.0)
    assert (trace.exposed_ms, trace.shown_ms) == (pytest.approx(50 + 15), pytest.approx(50 + 15 + 40))
    assert latencies.windows["picture"].summary(NOW_NS)["count"] == 2


def test_a_change_of_state_is_an_event_and_its_repetition_is_none() -> None:
    history = History()
    holding = msgspec.structs.replace(STATE, state=SessionState.HOLDING, code="stale", reason="too old")
    for k, state in enumerate((STATE, STATE, holding, holding, STATE)):
        history.add_state(state, NOW_NS + k)
    told = [event.text for event in history.events if event.kind != "lease"]
    assert told == ["engaged: the arm follows the hand", "holding: too old", "engaged: the arm follows the hand"]


def test_what_hinders_an_engaged_arm_is_told_once_a_second_at_most() -> None:
    history = History()
    for k in range(200):
        code = ("saturated", "ok")[k % 2]
        history.add_state(msgspec.structs.replace(STATE, code=code, reason=code), NOW_NS + k * 20 * NS_PER_MS)
    assert 2 <= sum(event.kind == "engaged" for event in history.events) <= 5


def frame(seq: int, capture_ns: int) -> VideoFrame:
    return VideoFrame(
        camera="side",
        seq=seq,
        capture_ns=capture_ns,
        capture_estimated=False,
        status=CameraStatus.LIVE,
        reason="",
        width=1,
        height=1,
        codec=Codec.JPEG,
        key=True,
        data=b"picture",
    )


def page(view: str, seq: int, age_ms: float, *, h264: bool = False) -> Shown:
    return Shown(h264=h264, views={view: Painted(seq=seq, age_ms=age_ms, fps=30.0)})


def test_what_was_painted_is_told_in_the_remote_sites_own_numbers() -> None:
    shown = ShownViews(session=9)
    for seq in range(5):
        came_ns = NOW_NS - (4 - seq) * NS_PER_S // 3
        shown.remember("camera/side", frame(seq, 1000 + seq), came_ns, 1004 + 25 * NS_PER_MS - NOW_NS, usable=True)
    told = shown.message(page("camera/side", 3, 41.0), LEASE, NOW_NS)
    assert told is not None
    assert told.views["side"].came == ViewCame(seq=4, age_ms=25.0, fps=3.0)
    assert (told.session, told.lease) == (9, LEASE)
    assert (told.session, told.views["side"].capture_ns, told.views["side"].age_ms) == (9, 1003, 41.0)
    assert shown.message(page("camera/side", 4, 41.0), LEASE, NOW_NS + 1) is None
    late = NOW_NS + NS_PER_S
    assert shown.message(page("camera/side", 77, 1.0), LEASE, late) is None
    assert shown.message(page("preview/left", 4, 1.0), LEASE, late) is None


def test_nothing_is_told_of_a_camera_while_its_clock_is_not_known() -> None:
    shown = ShownViews(session=9)
    shown.remember("camera/side", frame(3, 1003), NOW_NS, None, usable=True)
    assert shown.message(page("camera/side", 3, 41.0), LEASE, NOW_NS) is None


def test_pictures_that_no_page_can_decode_have_come_but_are_none_that_it_could_have_painted() -> None:
    shown = ShownViews(session=9)
    for seq in range(6):
        shown.remember("camera/side", frame(seq, 1000 + seq), NOW_NS, 0, usable=seq < 2)
    told = shown.message(page("camera/side", 1, 41.0, h264=True), LEASE, NOW_NS)
    assert told is not None
    assert told.h264
    assert (told.views["side"].came.seq, told.views["side"].came.fps) == (5, 2.0)


def test_a_picture_goes_on_as_it_came_with_its_exposure_by_our_clock() -> None:
    sent = view_frame("camera/side", frame(3, NOW_NS + APART_NS), ClockOffset(APART_NS, NS_PER_MS)).payload
    (length,) = LENGTH.unpack_from(sent)
    header = msgspec.json.decode(sent[2 : 2 + length])
    assert (header["capture_ms"], header["unsure_ms"], header["status"]) == (NOW_NS / NS_PER_MS, 1.0, "live")
    assert sent[2 + length :] == b"picture"


def test_a_picture_whose_clock_is_not_known_has_no_exposure() -> None:
    sent = view_frame("camera/side", frame(3, NOW_NS), None).payload
    (length,) = LENGTH.unpack_from(sent)
    assert msgspec.json.decode(sent[2 : 2 + length])["capture_ms"] is None
