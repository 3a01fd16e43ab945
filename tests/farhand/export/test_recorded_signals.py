"""What an exporter is given of a slow robot's gripper: each toggle that it was sent, at the time of that write."""

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from common.recording import foxglove
from common.recording.reader import KeptMessage
from farhand.export.recorded_signals import signals_of
from remote_site.recording.topics import ACTION, GRIPPER, WRITTEN, SentAction

NAMES, WIDE_M = ("waist", "elbow"), 0.05
TOGGLES, EVERY_MS, TICK_MS = 36, 400, 4


def messages(period_ms: int) -> list[KeptMessage]:
    """A toggle each 400 ms, a command each 4 ms, of which the robot gets one each period."""
    measured = GripperState(WIDE_M, None, GripperCommand.KEEP, GripperStatus.OPEN)
    kept, written, q = [KeptMessage(GRIPPER.name, 0, 0, msgspec.json.encode(measured))], (0, 0), np.zeros(2)
    for number in range(1, (TOGGLES + 1) * EVERY_MS // TICK_MS):
        t_ns, toggles = number * TICK_MS * NS_PER_MS, number * TICK_MS // EVERY_MS
        gripper = (GripperCommand.OPEN, GripperCommand.CLOSED)[toggles % 2] if toggles else GripperCommand.KEEP
        if t_ns - written[1] >= period_ms * NS_PER_MS:
            written = number, t_ns
            data = foxglove.joint_states(t_ns, NAMES, q, q, q)
            kept.append(KeptMessage(WRITTEN.name, t_ns, t_ns, data))
        action = SentAction(
            command=number,
            sent_ns=t_ns,
            q=q.tolist(),
            gripper=gripper,
            cause=None,
            written_command=written[0] or None,
            written_ns=written[1] or None,
        )
        kept.append(KeptMessage(ACTION.name, t_ns, t_ns, msgspec.json.encode(action)))
    return kept


@pytest.mark.parametrize("period_ms", [4, 20, 67])
def test_every_toggle_is_in_what_the_robot_was_sent(period_ms: int) -> None:
    sent = signals_of(messages(period_ms), NAMES).actions
    known = ~np.isnan(sent.opening)
    opening, t_s = sent.opening[known], sent.motion.t_ns[known] / NS_PER_S
    changes = np.flatnonzero(np.diff(opening, prepend=WIDE_M))
    assert opening[changes].tolist() == [0.0, WIDE_M] * (TOGGLES // 2)
    expected = np.arange(1, TOGGLES + 1) * EVERY_MS / 1000
    assert (t_s[changes] >= expected).all()
    assert (t_s[changes] - expected < (period_ms + TICK_MS) / 1000).all()
