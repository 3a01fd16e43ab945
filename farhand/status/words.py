"""One screen of a cell's status, in words: rows of a name and what is to be said of it; pure."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from common.clock import NS_PER_MS, NS_PER_S
from common.link.channels import STATE
from common.messages.robot import FOLLOWING, GripperState, HandLink, RobotState, SessionState
from common.messages.video import CameraStatus
from farhand.authority.lease import asker_words, holder_words, readiness_words
from farhand.status.observed import Observed, ObservedCamera

UNKNOWN = "not known"
LATE_BY_PERIODS = 0.5  # of a control tick, as its 99th percentile


class Mood(StrEnum):
    """The state of a row: as it should be, worth a look, or wrong."""

    GOOD = "good"
    PLAIN = "plain"
    WORTH_A_LOOK = "worth a look"
    WRONG = "wrong"


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the screen."""

    name: str
    words: str
    mood: Mood = Mood.PLAIN


MOODS = {
    SessionState.ENGAGED: Mood.GOOD,
    SessionState.HOLDING: Mood.WORTH_A_LOOK,
    SessionState.DISENGAGED: Mood.PLAIN,
    SessionState.FAULT: Mood.WRONG,
}


def rows_of(seen: Observed, state: RobotState, now_ns: int, software: str) -> list[Row]:
    """Every row now; `software` is the version of the one who looks."""
    return [
        *_silence(seen, now_ns),
        Row("state", f"{state.state.value}: {state.reason}", MOODS[state.state]),
        *_lease(state),
        _readiness(state),
        *_hand(state),
        *_latencies(seen, state),
        _control(seen, state),
        _states(seen, now_ns),
        *_cameras(seen, state, now_ns),
        _gripper(state),
        _recorder(state),
        *_cell(seen, software),
    ]


def as_builtins(seen: Observed, state: RobotState, now_ns: int, software: str) -> dict[str, Any]:
    """The status for programs: the rows, and the state as docs/wire-protocol.md has it."""
    return {
        "cell": seen.cell,
        "endpoint": seen.endpoint,
        "rows": rows_of(seen, state, now_ns, software),
        "state": state,
        "description": seen.description,
        "state_age_ms": (now_ns - seen.received_ns) / NS_PER_MS,
        "states_a_second": seen.state_rate.at(now_ns),
        "round_trip_ms": seen.round_trip_ms,
        "cameras": {name: _camera_builtins(camera, now_ns) for name, camera in seen.cameras.items()},
    }


def _camera_builtins(camera: ObservedCamera, now_ns: int) -> dict[str, Any]:
    return {"status": camera.status, "reason": camera.reason, "pictures_a_second": camera.rate.at(now_ns)}


def _silence(seen: Observed, now_ns: int) -> Iterator[Row]:
    silent_ns = now_ns - seen.received_ns
    if silent_ns > STATE.stale_after_ns:
        words = f"nothing has come for {silent_ns / NS_PER_S:.0f} s; all below is as it was then"
        yield Row("SILENT", words, Mood.WRONG)


def _lease(state: RobotState) -> Iterator[Row]:
    lease = state.lease
    if lease is None:
        yield Row("lease", "nobody holds it", Mood.WORTH_A_LOOK)
        return
    yield Row("lease", f"{lease} holds it, {holder_words(lease, state.t_ns)}")
    if (asks := asker_words(lease)) is not None:
        yield Row("asked for", asks, Mood.WORTH_A_LOOK)


def _readiness(state: RobotState) -> Row:
    if state.state in FOLLOWING:
        return Row("readiness", "the arm is engaged")
    return Row("readiness", readiness_words(state), Mood.GOOD if state.readiness.ready else Mood.WORTH_A_LOOK)


def _hand(state: RobotState) -> Iterator[Row]:
    link = state.hand_link
    if link is None:
        yield Row("hand samples", "none come from the lease's holder", Mood.WORTH_A_LOOK)
        return
    rate = f"{1000 / link.interval_ms:.1f} a second" if link.interval_ms > 0 else "no rate yet"
    words = f"{rate}, {link.loss:.1%} lost, jitter {link.jitter_ms:.0f} ms"
    yield Row("hand samples", words)
    if link.reason:
        yield Row("hand's link", link.reason, Mood.WRONG)
    refused = ", ".join(f"{count} {code}" for code, count in state.rejected.items() if count)
    if refused:
        yield Row("refused", f"{refused}, since the remote site started")


def _latencies(seen: Observed, state: RobotState) -> Iterator[Row]:
    if state.hand_link is not None:
        yield Row("hand age", _age(state.hand_link))
    limit = f"{state.age_limit_ms:.0f} ms old, at {state.speed_scale:.0%} of full speed"
    yield Row("obeyed", f"up to {limit}{_obeyed(state)}")
    trip = f"{seen.round_trip_ms:.1f} ms" if seen.round_trip_ms is not None else "no answer"
    yield Row("round trip", f"{trip} from here{_clocks(state)}")


def _age(link: HandLink) -> str:
    parts = ("network", link.network_ms), ("clocks", link.clock_ms), ("tracking", link.tracking_ms)
    if link.age_ms is None:
        return f"{UNKNOWN}: the clocks' offset is not"
    sums = ", ".join(f"{name} {_ms(part)}" for name, part in parts)
    return f"{_ms(link.age_ms)} at arrival (one sample in twenty is older): {sums}"


def _ms(value: float | None) -> str:
    return UNKNOWN if value is None else f"{value:.0f} ms"


def _obeyed(state: RobotState) -> str:
    obeyed, clock = state.obeyed, state.clock
    if obeyed is None or clock is None:
        return ""
    took_ns = obeyed.command_ns - obeyed.capture_ns - clock.remote_minus_local_ns
    return f"; the last took {took_ns / NS_PER_MS:.0f} ms from exposure to command"


def _clocks(state: RobotState) -> str:
    if state.clock is None:
        return ""
    return f"; the operator's clock is known to {state.clock.uncertainty_ns / NS_PER_MS:.1f} ms"


def _control(seen: Observed, state: RobotState) -> Row:
    timing, cell = state.timing, seen.description
    words = f"{timing.hz:.1f} Hz, p99 {timing.late_p99_us / 1000:.2f} ms late, {timing.missed} of {timing.ticks} missed"
    late = cell is not None and timing.late_p99_us > LATE_BY_PERIODS * 1e6 / cell.control_hz
    if not timing.real_time:
        words += "; without real-time scheduling"
    return Row("control", words, Mood.WORTH_A_LOOK if late or not timing.real_time else Mood.PLAIN)


def _states(seen: Observed, now_ns: int) -> Row:
    return Row("states", f"{_rate(seen.state_rate.at(now_ns))} here")


def _rate(rate: float | None) -> str:
    return "no rate yet" if rate is None else f"{rate:.1f} a second"


def _cameras(seen: Observed, state: RobotState, now_ns: int) -> Iterator[Row]:
    if (trouble := state.video_link) is not None:
        yield Row("pictures' way", trouble.reason, Mood.WORTH_A_LOOK)
    if not seen.cameras:
        yield Row("pictures", seen.pictures)
    for name, camera in seen.cameras.items():
        yield _camera(name, camera, now_ns)


def _camera(name: str, camera: ObservedCamera, now_ns: int) -> Row:
    if camera.status is None:
        return Row(f"camera {name}", "nothing has come yet", Mood.WORTH_A_LOOK)
    why = f": {camera.reason}" if camera.reason else ""
    mood = Mood.PLAIN if camera.status is CameraStatus.LIVE else Mood.WRONG
    return Row(f"camera {name}", f"{camera.status.value}, {_rate(camera.rate.at(now_ns))}{why}", mood)


def _gripper(state: RobotState) -> Row:
    gripper = state.gripper
    if gripper is None:
        return Row("gripper", "none is measured")
    toggled = f"; a toggle would command: {state.gripper_next.value}"
    return Row("gripper", _measured(gripper) + toggled)


def _measured(gripper: GripperState) -> str:
    force = "" if gripper.force is None else f", {gripper.force:.0f} N"
    return f"{gripper.status.value}, {gripper.opening * 1000:.0f} mm{force}"


def _recorder(state: RobotState) -> Row:
    recording = state.recording
    if recording is None:
        return Row("recorder", "none runs beside the remote site")
    if recording.alarm:
        return Row("recorder", f"NOT RECORDING: {recording.alarm}", Mood.WRONG)
    words = "writes" if recording.writing else "waits until it is asked" if recording.on_request else "does not write"
    if recording.episode:
        words += f", episode {recording.episode} {'under way' if recording.episode_open else 'has ended'}"
    if recording.lost:
        words += f", {recording.lost} lost"
    return Row("recorder", words, Mood.WORTH_A_LOOK if recording.lost else Mood.PLAIN)


def _cell(seen: Observed, software: str) -> Iterator[Row]:
    cell = seen.description
    if cell is None:
        yield Row("cell", f"{seen.cell} at {seen.endpoint}; robot, driver and version are {UNKNOWN}: no answer")
        return
    yield Row("cell", f"{cell.cell} at {seen.endpoint}, robot {cell.robot}, driver {cell.driver}")
    differs = cell.software != software
    words = f"{cell.software} there, {software} here" if differs else cell.software
    yield Row("version", words, Mood.WORTH_A_LOOK if differs else Mood.PLAIN)
