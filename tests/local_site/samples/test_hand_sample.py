"""The published sample: what it states of the points' certainty, and that no receiver has to refuse it."""

import numpy as np
import pytest

from common.link.channels import HAND
from common.messages.codec import decode, encode
from common.messages.hand import (
    ClockSync,
    HandArm,
    Intent,
    OperatorSettings,
    PointCovariances,
    TrackingStatus,
)
from local_site.samples.hand_sample import HandSampler, OpenHand
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.tracking.tracker import ArmEstimate
from tests.present import present

WRIST = np.array([0.4, 0.3, 0.5])
WRIST_COVARIANCE = np.array([[4.0, 1.0, -2.0], [1.0, 9.0, 0.5], [-2.0, 0.5, 16.0]]) * 1e-6


def through_codec(sample):
    """The sample as a receiver gets it."""
    return decode(encode(sample), HandArm, HAND.max_bytes)


def received(covariances):
    estimate = ArmEstimate(5, TrackingStatus.TRACKED, "", wrist=WRIST, covariances=covariances)
    return through_codec(HandSampler(3).sample(estimate, OpenHand(), 0, None, None, 0)).covariance


def test_the_upper_half_of_a_covariance_arrives_under_the_points_name():
    came = received({"wrist": WRIST_COVARIANCE})
    assert came.wrist == pytest.approx((4e-6, 1e-6, -2e-6, 9e-6, 0.5e-6, 16e-6), rel=0.05, abs=5e-8)
    assert came == PointCovariances(wrist=came.wrist)


def test_an_estimate_without_covariances_says_nothing():
    assert received({}) is None


@pytest.mark.parametrize("spoiled", [np.full((3, 3), np.nan), np.diag([1e-6, np.inf, 1e-6]), -WRIST_COVARIANCE])
def test_what_is_no_covariance_is_unknown_and_the_sample_still_arrives(spoiled):
    assert received({"wrist": spoiled, "elbow": WRIST_COVARIANCE}).wrist is None


@pytest.mark.parametrize("method", ["one_euro", "mean"])
def test_smoothing_leaves_covariances_as_measured(method):
    smoother = make_smoother(SmoothingConfig(method=method))
    for k in range(3):
        offset = np.array([0.01 * k, 0.0, 0.0])
        measured = ArmEstimate(
            k * 33_000_000, TrackingStatus.TRACKED, "", wrist=WRIST + offset, covariances={"wrist": WRIST_COVARIANCE}
        )
        smoothed = smoother.smooth(measured)
    assert smoothed.covariances["wrist"] is WRIST_COVARIANCE
    assert not np.array_equal(present(smoothed.wrist), present(measured.wrist))


def test_a_sample_says_when_it_was_sent_under_which_lease_by_which_clock_and_with_what_intent():
    clock = ClockSync(remote_minus_local_ns=-5, uncertainty_ns=2, measured_ns=9)
    estimate = ArmEstimate(5, TrackingStatus.LOST, "gone")
    intent = Intent(hold=True, settings=OperatorSettings(lease=41, scale=0.5))
    sent = through_codec(HandSampler(3).sample(estimate, OpenHand(), 41, clock, intent, 77))
    assert (sent.session, sent.lease, sent.clock, sent.intent, sent.sent_ns) == (3, 41, clock, intent, 77)
