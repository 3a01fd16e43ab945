"""A hand is tracked in any posture; what a posture hides is told."""

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from local_site.simulation.hand import FIST, FLAT, POINTING, U_SHAPE
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.learned.simulated_landmarks import shown_tracker, simulated_landmarks

KNOWN, HELD, INSTANTS = 20, 20, 45
WRIST_MM, UNSURE_M = 12.0, 0.03


def black(pictures):
    return [np.full_like(picture, 9) for picture in pictures]


@pytest.fixture
def shown(monkeypatch, moving):
    """A tracker that knows the operator."""
    shown = shown_tracker(monkeypatch, moving.projections)
    for k in range(KNOWN):
        shown.track(moving.views(k), simulated_landmarks(moving, k))
    return shown


def hold(shown, moving, rest):
    """The last estimate of a hand that is held like this, shown by its landmarks alone."""
    for k in range(KNOWN, KNOWN + HELD):
        estimate = shown.track(moving.views(k, black), simulated_landmarks(moving, k, rest=rest))
    return estimate, moving.truths[KNOWN + HELD - 1]


def test_a_fist_is_degraded_with_the_reason(shown, moving):
    estimate, truth = hold(shown, moving, FIST)
    assert estimate.status is TrackingStatus.DEGRADED
    assert TrackingReason.FIST in estimate.reason
    assert 1e3 * np.linalg.norm(estimate.wrist - truth.wrist) < WRIST_MM


@pytest.mark.parametrize("rest", [U_SHAPE, FLAT], ids=["gripper", "flat"])
def test_a_hand_that_hides_nothing_has_no_such_reason(shown, moving, rest):
    estimate, _ = hold(shown, moving, rest)
    assert estimate.status is TrackingStatus.TRACKED
    assert TrackingReason.FIST not in estimate.reason
    assert not estimate.thumb_inferred


def test_a_pointing_hand_is_tracked_with_its_thumb_inferred(shown, moving):
    estimate, _ = hold(shown, moving, POINTING)
    assert estimate.status is TrackingStatus.TRACKED
    assert estimate.thumb_inferred
    assert TrackingReason.THUMB_INFERRED in estimate.reason


def test_a_hand_that_suddenly_fits_far_worse_is_degraded_and_its_tips_are_unsure(shown, moving):
    k = KNOWN
    turned = simulated_landmarks(moving, k, rest=POINTING)
    before = shown.track(moving.views(k), simulated_landmarks(moving, k))
    estimate = shown.track(moving.views(k + 1, black), turned)
    assert before.status is TrackingStatus.TRACKED
    assert estimate.status is TrackingStatus.DEGRADED
    assert TrackingReason.HAND_UNCLEAR in estimate.reason
    for name in ("index", "thumb"):
        assert np.linalg.eigvalsh(estimate.covariances[name])[0] > UNSURE_M**2


def test_a_fist_that_opens_is_tracked_again(shown, moving):
    hold(shown, moving, FIST)
    for k in range(KNOWN + HELD, INSTANTS):
        estimate = shown.track(moving.views(k), simulated_landmarks(moving, k))
    assert estimate.status is TrackingStatus.TRACKED
    assert not estimate.thumb_inferred
