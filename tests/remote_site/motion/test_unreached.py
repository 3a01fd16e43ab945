"""A target that the general solver cannot reach is told with how far the tool stays from it."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import transform
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.target_tracker import choose_target_tracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Code
from remote_site.teleop.config import prediction
from tests.remote_site.arms_followed import OFFSET_WRIST
from tests.remote_site.remote_loop import TICK_NS, arm

MODEL, LIMITS = arm(OFFSET_WRIST)
START = OFFSET_WRIST.robot.start


def test_a_target_out_of_reach_is_told_with_the_distance_that_is_left() -> None:
    tracker = choose_target_tracker(OFFSET_WRIST.robot, prediction(OFFSET_WRIST), MODEL, LIMITS)
    tracker.reset(0, START)
    base_T_tool = MODEL.forward(START)
    motion, why = JointMotion.at_rest(START), None
    for tick in range(1, 1500):
        up = np.array([0.0, 0.0, min(0.3 * tick * TICK_NS / NS_PER_S, 1.0)])
        base_T_target = transform(base_T_tool[:3, :3], base_T_tool[:3, 3] + up)
        if tick % 8 == 0:
            sample = ToolSample(tick * TICK_NS, tick * TICK_NS + NS_PER_MS, base_T_target, None, None)
            why = tracker.aim(sample)
        motion = tracker.at(tick * TICK_NS + NS_PER_MS, motion, 1.0)
    left_mm = 1e3 * np.linalg.norm(base_T_target[:3, 3] - MODEL.forward(motion.q)[:3, 3])
    assert left_mm > 200.0
    assert why is not None
    assert why.code is Code.UNREACHED
    assert float(why.sentence.split(" mm")[0].split()[-1]) == pytest.approx(left_mm, abs=2.0)
