"""Frames and payloads on the line: lost, changed and random bytes, and the time they take."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.clock import NS_PER_MS
from common.messages.robot import GripperCommand
from remote_site.drivers.c500c.emulation import EmulatedLine
from remote_site.drivers.c500c.protocol import (
    LARGEST_ANSWER,
    Activation,
    ControllerState,
    Fault,
    Flag,
    Kind,
    Parser,
    ProtocolFrame,
    Setpoint,
)

ANGLES = st.floats(-math.pi, math.pi)
FRAMES = st.builds(ProtocolFrame, st.integers(0, 255), st.integers(0, 255), st.binary(max_size=LARGEST_ANSWER))


@given(st.lists(FRAMES, max_size=5), st.binary(max_size=20), st.integers(1, 40))
def test_frames_are_found_however_they_come(frames, noise, chunk):
    noise = noise.replace(b"\xa5", b"")
    data = noise + b"".join(frame.encoded for frame in frames)
    parser, found = Parser(LARGEST_ANSWER), []
    for k in range(0, len(data), chunk):
        found += parser.feed(data[k : k + chunk])
    assert found == frames
    assert parser.damaged == 0


@given(FRAMES, st.data())
def test_a_damaged_frame_is_never_taken_for_another(frame, data):
    encoded = bytearray(frame.encoded)
    place = data.draw(st.integers(0, len(encoded) - 1))
    encoded[place] ^= data.draw(st.integers(1, 255))
    if data.draw(st.booleans()):
        del encoded[place]
    found = Parser(LARGEST_ANSWER).feed(bytes(encoded) + ProtocolFrame(9, Kind.POLL).encoded * 20)
    # a checksum may end in the byte with which the next frame starts: then a lost last byte damages nothing
    assert all(each in (ProtocolFrame(9, Kind.POLL), frame) for each in found)
    assert found


@pytest.mark.parametrize("byte", [3, 255])
def test_a_setpoint_that_commands_what_no_gripper_does_is_refused(byte):
    payload = bytearray(Setpoint(1, (0.0,) * 6, GripperCommand.CLOSED, 50).payload)
    payload[-2] = byte
    with pytest.raises(ValueError, match="no command of the gripper"):
        Setpoint.parse(bytes(payload))


def test_nothing_is_commanded_of_the_gripper_by_zeros():
    assert Setpoint.parse(bytes(Setpoint.FORMAT.size)).gripper is GripperCommand.KEEP


@given(st.binary(max_size=300))
def test_random_bytes_raise_nothing(data):
    Parser(LARGEST_ANSWER).feed(data)


@given(st.tuples(*[ANGLES] * 6), st.integers(0, 65535), st.sampled_from(GripperCommand), st.integers(1, 100))
def test_payloads_survive_the_line(joints, count, gripper, percent):
    setpoint = Setpoint.parse(Setpoint(count, joints, gripper, percent).payload)
    assert setpoint.joints == pytest.approx(joints, abs=1e-6)
    assert (setpoint.count, setpoint.gripper, setpoint.grip_percent) == (count, gripper, percent)
    activation = Activation.parse(Activation(count, joints, 67).payload)
    assert (activation.count, activation.period_ms) == (count, 67)
    state = ControllerState.parse(
        ControllerState(Flag.ACTIVE, Fault.BLOCKED, 2, count, count, count, 0.0501, joints).payload
    )
    assert (state.flags, state.fault, state.queued, state.begun) == (Flag.ACTIVE, Fault.BLOCKED, 2, count)
    assert state.opening_m == pytest.approx(0.0501, abs=1e-5)


def test_bytes_take_their_time():
    line = EmulatedLine(baud=57600)
    line.push(b"x" * 36, 0)
    assert len(line.pull(3 * NS_PER_MS)) == 17
    assert len(line.pull(7 * NS_PER_MS)) == 19
