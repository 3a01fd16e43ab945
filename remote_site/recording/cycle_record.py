"""One control cycle as bytes and back, bit for bit: what went into it, and what came of it."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import msgspec
import numpy as np

from common.errors import MessageError
from common.geometry import Array
from common.messages.robot import AssistState, Engagement, GripperCommand, SessionState
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import RobotReport
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, Reason
from remote_site.session.samples import Accepted
from remote_site.session.state_machine import Answer
from remote_site.teleop.cycle import Command, CycleInput


class ObeyedSample(NamedTuple):
    """The hand sample that a motion follows: captured at `capture_ns` by the operator's clock, `born_ns` by ours."""

    session: int
    seq: int
    capture_ns: int
    born_ns: int


class CycleOutcome(NamedTuple):
    """The decision of a cycle, and what became of it.

    `motion`, `gripper` and `activate_at` are the pipeline's command; `ordered` is what the driver's process was ordered
    instead of `motion` where a stop was under way, None where it was ordered nothing. `written` is what that process
    had given the robot last when the cycle began, after every limit: `seq` is the number of the order that it comes
    from, `t_ns` when it was written. The robot was measured at `measured_ns`, with the joint speeds `measured_dq` (n,).
    Cycles are numbered from 1 at the site's start, so that a gap shows; the rest is the pipeline's snapshot.
    """

    number: int

    motion: JointMotion
    gripper: GripperCommand
    activate_at: Array | None
    ordered: JointCommand | None
    written: JointCommand | None
    measured_ns: int
    measured_dq: Array
    state: SessionState
    reason: Reason
    obeys: ObeyedSample | None
    engagement: Engagement | None
    engagements: int
    target: Array
    gripper_toggles: int
    readiness: Answer
    held: bool
    answers: tuple[Answer, ...]
    rejected: Mapping[Code, int]
    assist: AssistState | None


def outcome_of(number: int, command: Command, ordered: JointCommand | None, report: RobotReport) -> CycleOutcome:
    """Build what is kept of a cycle's command, with what was really sent; `report` is the one that it began with."""
    snapshot = command.snapshot
    return CycleOutcome(
        number,
        command.motion,
        command.gripper,
        command.activate_at,
        ordered,
        report.written,
        report.t_ns,
        report.dq,
        snapshot.state,
        snapshot.reason,
        _obeyed(snapshot.obeys),
        snapshot.engagement,
        snapshot.engagements,
        snapshot.target,
        snapshot.gripper_toggles,
        snapshot.readiness,
        snapshot.held,
        snapshot.answers,
        snapshot.rejected,
        snapshot.assist,
    )


def encode_input(given: CycleInput) -> bytes:
    """A cycle's input; arrays as their bytes, so that each number comes back as it was."""
    return ENCODER.encode(given)


def decode_input(data: bytes) -> CycleInput:
    """The input that `encode_input` wrote; MessageError for anything else."""
    given: CycleInput = _decoded(INPUT_DECODER, data)
    return given


def encode_outcome(outcome: CycleOutcome) -> bytes:
    """A cycle's outcome, as `encode_input`."""
    return ENCODER.encode(outcome)


def decode_outcome(data: bytes) -> CycleOutcome:
    """The outcome that `encode_outcome` wrote; MessageError for anything else."""
    outcome: CycleOutcome = _decoded(OUTCOME_DECODER, data)
    return outcome


def _obeyed(sample: Accepted | None) -> ObeyedSample | None:
    if sample is None:
        return None
    hand = sample.sample
    return ObeyedSample(hand.session, hand.seq, hand.capture_ns, sample.born_ns)


def _decoded(decoder: "msgspec.msgpack.Decoder[Any]", data: bytes) -> Any:
    try:
        return decoder.decode(data)
    except (msgspec.DecodeError, ValueError) as error:
        raise MessageError("invalid", f"no control cycle of this release: {error}") from error


def _array_out(value: object) -> object:
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        return value.shape, value.tobytes()
    raise NotImplementedError(f"{type(value).__name__} has no form in a recording")


def _array_in(_kind: type, value: Any) -> Array:
    shape, data = value
    return np.frombuffer(data, np.float64).reshape(shape).copy()


ENCODER = msgspec.msgpack.Encoder(enc_hook=_array_out)
INPUT_DECODER = msgspec.msgpack.Decoder(CycleInput, dec_hook=_array_in)
OUTCOME_DECODER = msgspec.msgpack.Decoder(CycleOutcome, dec_hook=_array_in)
