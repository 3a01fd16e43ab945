"""An arm that old samples slow down keeps to the tool's path, though its joints are too slow for the hand's turn."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, rotation_from_vector
from remote_site.config import RemoteConfig
from remote_site.safety.config import SafetyConfig
from tests.remote_site.arms_followed import INDEX, THUMB, smooth
from tests.remote_site.remote_loop import RemoteLoop, hand

SAMPLE_TICKS = 16
DELAY_NS = 100 * NS_PER_MS
TURN_RAD = 0.3
MAX_OFF_MM = 30.0  # without pacing up to 243 mm


def turned_and_carried(axis: int) -> Array:
    """The tool's distance (n,) in mm from its straight path, while the hand turns, moves 20 cm and turns back."""
    safety = SafetyConfig(t_soft_ms=400.0, t_latch_ms=1000.0)
    loop = RemoteLoop(RemoteConfig(safety=safety))
    loop.run(SAMPLE_TICKS * 31, lambda _t_ns: (0.0, 0.0, 0.3), every=SAMPLE_TICKS)
    loop.hand_seq = 1000
    begin_ns, start = loop.clock.now_ns(), loop.model.forward(loop.sent.q)[:3, 3]
    under_way, off = [], []
    for k in range(1000):
        now_ns = loop.clock.now_ns()
        if k % SAMPLE_TICKS == 0:
            t = (now_ns - begin_ns) / NS_PER_S
            turn = TURN_RAD * smooth((t - 0.2) / 0.4) * (1.0 - smooth((t - 1.0) / 0.5)) * np.eye(3)[axis]
            wrist = np.array([-0.2 * smooth((t - 1.0) / 1.5), 0.0, 0.3])
            points = [wrist, *(wrist + rotation_from_vector(turn) @ tip for tip in (INDEX, THUMB))]
            at, index, thumb = (tuple(point.tolist()) for point in points)
            loop.hand_seq += 1
            under_way.append((now_ns + DELAY_NS, hand(loop.hand_seq, now_ns, at, index=index, thumb=thumb)))
        due = [sample for due_ns, sample in under_way if due_ns <= now_ns]
        under_way = [waiting for waiting in under_way if waiting[0] > now_ns]
        loop.tick(*due)
        off.append(1e3 * np.linalg.norm((loop.model.forward(loop.sent.q)[:3, 3] - start)[[0, 2]]))
    return np.array(off)


@pytest.mark.slow
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_slowed_arm_keeps_to_the_path_while_the_hand_turns(axis: int) -> None:
    off = turned_and_carried(axis)
    assert off.max() < MAX_OFF_MM
    assert off[-1] < 2.0
