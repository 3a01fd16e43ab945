"""One wrong frame is passed on as it is and leaves no trace in the frames after it."""

import numpy as np

from common.clock import NS_PER_S
from common.messages.hand import TrackingStatus
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.tracking.tracker import ArmEstimate

HAND = np.array([0.1, 0.2, 0.3])
AWAY = HAND + np.array([0.0, 0.6, 0.8])


def smoothed(wrists, method="one_euro"):
    """The wrists as they are sent, of frames a thirtieth of a second apart; None for a lost hand."""
    smoother = make_smoother(SmoothingConfig(method=method))
    sent = []
    for k, wrist in enumerate(wrists):
        status = TrackingStatus.LOST if wrist is None else TrackingStatus.TRACKED
        sent.append(smoother.smooth(ArmEstimate(k * NS_PER_S // 30, status, "", wrist=wrist)).wrist)
    return sent


def test_a_jump_leaves_no_trace():
    for method in ("one_euro", "mean"):
        for jumps in (1, 2):
            sent = smoothed([*[HAND] * 10, *[AWAY] * jumps, *[HAND] * 5], method)
            assert all(np.array_equal(wrist, AWAY) for wrist in sent[10 : 10 + jumps])
            np.testing.assert_allclose(sent[10 + jumps :], [HAND] * 5, atol=1e-12)


def test_the_third_in_a_row_is_where_the_arm_is():
    sent = smoothed([*[HAND] * 10, *[AWAY] * 6])
    np.testing.assert_allclose(sent[10:], [AWAY] * 6, atol=1e-12)


def test_what_comes_after_the_third_is_smoothed_again():
    beside = AWAY + np.array([0.0, 0.02, 0.0])
    sent = smoothed([*[HAND] * 10, *[AWAY] * 3, beside])
    assert AWAY[1] < sent[-1][1] < beside[1]


def test_a_quick_hand_is_smoothed_as_ever():
    way = [HAND + np.array([0.0, 0.08 * k, 0.0]) for k in range(8)]
    sent = smoothed(way)
    assert 0 < sent[-1][1] - HAND[1] < way[-1][1] - HAND[1]


def test_a_hand_found_again_elsewhere_has_not_jumped():
    sent = smoothed([*[HAND] * 5, None, AWAY, HAND])
    np.testing.assert_allclose(sent[6], AWAY)
    np.testing.assert_allclose(sent[7], HAND)
