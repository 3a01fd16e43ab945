"""What a predicted target says of its motion belongs together: each is the change of the one before."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.motion.config import ControlConfig
from remote_site.motion.target_predictor import TargetPredictor
from tests.remote_site.motion.aimed import aim

PERIOD_MS, STEP_NS = 33, NS_PER_MS // 4


@pytest.mark.parametrize("speed_m_s", [0.05, 0.5])
def test_a_targets_speed_and_acceleration_are_the_changes_of_its_place_and_speed(speed_m_s: float) -> None:
    """While it catches up with a hand that moves from the first, which is the slow part, and afterwards."""
    predictor, h_s, hardest = TargetPredictor(6, ControlConfig()), STEP_NS / NS_PER_S, 0.0
    predictor.reset(0, np.zeros(6))
    for k in range(1, 40):
        now_ns = k * PERIOD_MS * NS_PER_MS
        aim(predictor, now_ns - 20 * NS_PER_MS, speed_m_s * k * PERIOD_MS / 1e3 * np.eye(6)[0], now_ns)
        for after_ms in (2, 10, 30):
            at_ns = now_ns + after_ms * NS_PER_MS
            before, here, after = (predictor.at(at_ns + step) for step in (-STEP_NS, 0, STEP_NS))
            assert here[1][0] == pytest.approx((after[0][0] - before[0][0]) / (2 * h_s), abs=1e-4)
            assert here[2][0] == pytest.approx((after[1][0] - before[1][0]) / (2 * h_s), abs=2e-3)
            hardest = max(hardest, abs(here[2][0]))
    assert hardest > 0.1
