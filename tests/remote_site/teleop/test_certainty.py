"""What the covariance of the point that the tool copies lets the arm do: slower, then held."""

import numpy as np
import pytest

from common.messages.hand import HandPoint, PointCovariances
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.safety.config import CertaintyConfig
from remote_site.teleop.certainty import certainty_of
from tests.remote_site.remote_loop import RemoteLoop, hand

CONFIG = CertaintyConfig()
SAMPLE_TICKS = 8


def of(sigma_mm):
    """A covariance whose trace is the square of a sigma."""
    variance = (sigma_mm * 1e-3) ** 2 / 3
    return (variance, 0.0, 0.0, variance, 0.0, variance)


def judged(covariance, config=CONFIG):
    return certainty_of(covariance, HandPoint.WRIST, config)


def points(wrist_mm=1.0, tips_mm=1.0):
    return PointCovariances(wrist=of(wrist_mm), index=of(tips_mm), thumb=of(tips_mm))


def test_a_sender_that_knows_no_covariance_is_believed():
    for covariance in (None, PointCovariances()):
        certainty = judged(covariance)
        assert (certainty.position, certainty.sigma_mm) == (1.0, 0.0)
    assert judged(PointCovariances(), CertaintyConfig(position_sure_mm=0.5)).position == 1.0


@pytest.mark.parametrize(("wrist_mm", "position"), [(1.0, 1.0), (10.0, 1.0), (25.0, 0.6), (40.0, 0.2)])
def test_the_fraction_falls_from_sure_to_poor(wrist_mm, position):
    assert judged(points(wrist_mm)).position == pytest.approx(position)


def test_a_poor_or_broken_wrist_leaves_no_speed():
    assert judged(points(40.1)).position == 0.0
    assert judged(PointCovariances(wrist=(np.inf, 0, 0, 1, 0, 1))).position == 0.0
    assert judged(PointCovariances(wrist=(np.nan, 0, 0, 1, 0, 1))).position == 0.0


@pytest.mark.parametrize("bounds", [{"position_sure_mm": 40.0}, {"turn_poor_deg": 8.0}])
def test_poor_must_lie_beyond_sure(bounds):
    with pytest.raises(ValueError, match="must be above"):
        CertaintyConfig(**bounds)


def running(loop, seconds, covariance, step=None):
    """A hand that jumps by `step`; the fastest joint speeds seen."""
    place = np.array([0.0, 0.0, 0.3]) + (step if step is not None else np.zeros(3))
    begin = len(loop.log)
    loop.run(round(seconds * 250), lambda _t_ns: tuple(place.tolist()), covariance=covariance)
    return np.abs(np.array([motion.dq for motion in loop.log[begin:]])).max()


def engaged():
    loop = RemoteLoop()
    running(loop, 1.0, points())
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


def test_an_uncertain_wrist_slows_the_arm():
    step = np.array([0.0, -0.1, 0.0])
    sure, unsure = (running(engaged(), 0.5, points(wrist_mm), step) for wrist_mm in (1.0, 38.0))
    assert unsure < 0.5 * sure


def test_a_poor_wrist_holds_the_arm_with_its_reason_and_good_ones_resume():
    loop = engaged()
    running(loop, 0.1, points(41.0))
    assert loop.states[-1] is SessionState.HOLDING
    assert loop.snapshot.rejected[Code.UNCERTAIN] > 0
    running(loop, 0.5, points())
    assert loop.states[-1] is SessionState.ENGAGED


def test_poor_tips_hold_the_orientation_while_the_position_goes_on():
    loop = engaged()
    before = loop.model.forward(loop.sent.q)
    for k in range(25):
        wrist = (0.0, -0.002 * k, 0.3)
        turn = 0.01 * k
        index = (0.02 + 0.17 * turn, wrist[1] - 0.17, 0.3)
        loop.hand_seq += 1
        sample = hand(loop.hand_seq, loop.clock.now_ns(), wrist, index=index, covariance=points(tips_mm=100.0))
        for j in range(SAMPLE_TICKS):
            loop.tick(*([sample] if j == 0 else []))
    after = loop.model.forward(loop.sent.q)
    assert loop.states[-1] is SessionState.ENGAGED
    assert after[0, 3] - before[0, 3] > 0.04
    assert np.abs(after[:3, :3] - before[:3, :3]).max() < 1e-3
