"""Smoothing: calmer at rest, close behind in motion, and honest about gaps."""

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.geometry import rotation_from_vector
from common.messages.hand import TrackingStatus
from local_site.samples.smoothing import POINTS, SmoothingConfig, make_smoother
from local_site.tracking.tracker import ArmEstimate
from tests.present import present

HAND = {"wrist": np.zeros(3), "index": np.array([0.17, 0.02, 0.03]), "thumb": np.array([0.12, -0.02, -0.05])}
ELBOW = np.array([0.2, 0.05, -0.2])
METHODS = ["one_euro", "mean"]


def arm(t_s, offset=(0, 0, 0), turn=(0, 0, 0), noise=0.0, rng=None, status=TrackingStatus.TRACKED, **changes):
    rotation = rotation_from_vector(np.array(turn, float))
    points = {name: rotation @ point + offset for name, point in {**HAND, "elbow": ELBOW}.items()}
    if noise:
        points = {name: point + rng.normal(0, noise, 3) for name, point in points.items()}
    return ArmEstimate(t_ns=round(t_s * NS_PER_S), status=status, reason="", **{**points, **changes})


def run(method, make, count, fps=30.0, **settings):
    smoother = make_smoother(SmoothingConfig(method=method, **settings))
    return [smoother.smooth(make(k / fps)) for k in range(count)]


@pytest.mark.parametrize("method", METHODS)
def test_noise_at_rest_is_reduced_on_every_point(method):
    rng = np.random.default_rng(3)
    smooth = run(method, lambda t_s: arm(t_s, noise=0.002, rng=rng), 600)
    truth = arm(0.0)
    for name in POINTS:
        errors = np.array([getattr(estimate, name) - getattr(truth, name) for estimate in smooth[60:]])
        assert errors.std() < 0.002 * 0.55, name
        assert np.abs(errors.mean(axis=0)).max() < 0.0005, name


def lag_s(method, speed_m_s=0.25):
    """How long ago a point in steady motion was where the smoothed one is."""
    moving = run(method, lambda t_s: arm(t_s, offset=(speed_m_s * t_s, 0, 0)), 120)
    return (119 / 30 * speed_m_s - moving[-1].wrist[0]) / speed_m_s


def test_one_euro_lags_half_as_much_as_the_mean_of_nine_frames():
    assert lag_s("mean") == pytest.approx(4 / 30, rel=0.01)
    assert lag_s("one_euro") < 0.5 * lag_s("mean")


def test_one_euro_follows_fast_motion_more_closely():
    assert lag_s("one_euro", 0.6) < lag_s("one_euro", 0.2) < lag_s("one_euro", 0.05)


def test_a_turning_hand_keeps_its_size():
    turning = run("one_euro", lambda t_s: arm(t_s, turn=(0, 0, 1.5 * t_s)), 60)
    for estimate in turning:
        assert np.linalg.norm(estimate.index - estimate.wrist) == pytest.approx(np.linalg.norm(HAND["index"]))
        assert np.linalg.norm(estimate.thumb - estimate.index) == pytest.approx(
            np.linalg.norm(HAND["thumb"] - HAND["index"])
        )


def test_the_smoothed_hand_turns_behind_the_true_one_and_arrives():
    stop_s = 1.0
    turned = run("one_euro", lambda t_s: arm(t_s, turn=(0, 0, 1.2 * min(t_s, stop_s))), 120)
    angle = [np.arctan2(e.index[1] - e.wrist[1], e.index[0] - e.wrist[0]) for e in turned]
    start = np.arctan2(HAND["index"][1], HAND["index"][0])
    assert start < angle[20] < start + 1.2 * 20 / 30
    assert angle[-1] == pytest.approx(start + 1.2, abs=0.01)
    assert np.all(np.diff(angle) > -1e-6)


def test_a_hand_past_half_a_turn_takes_the_short_way():
    smoother = make_smoother(SmoothingConfig())
    smoother.smooth(arm(0.0, turn=(0, 0, 3.1)))
    index = present(smoother.smooth(arm(1 / 30, turn=(0, 0, -3.1))).index)
    angle = np.arctan2(index[1], index[0]) - np.arctan2(HAND["index"][1], HAND["index"][0])
    assert abs(np.angle(np.exp(1j * (angle - np.pi)))) < 0.06


@pytest.mark.parametrize("method", METHODS)
def test_the_first_estimate_is_kept_as_it_is(method):
    first = run(method, lambda t_s: arm(t_s, offset=(1.0, 2.0, 3.0)), 1)[0]
    for name in POINTS:
        assert getattr(first, name) == pytest.approx(getattr(arm(0.0, offset=(1.0, 2.0, 3.0)), name))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("missing", POINTS)
def test_an_absent_point_stays_absent_and_starts_anew(method, missing):
    smoother = make_smoother(SmoothingConfig(method=method))
    for k in range(10):
        smoother.smooth(arm(k / 30))
    gap = smoother.smooth(arm(10 / 30, **{missing: None}))
    assert getattr(gap, missing) is None
    assert all(getattr(gap, name) is not None for name in POINTS if name != missing)
    back = smoother.smooth(arm(11 / 30, offset=(0.3, 0, 0)))
    moved = getattr(arm(0.0, offset=(0.3, 0, 0)), missing)
    if missing in {"elbow", "wrist"}:
        assert getattr(back, missing) == pytest.approx(moved)
    else:
        # A tip starts again about its wrist, which was there all the time and comes gradually.
        offset = getattr(back, missing) - back.wrist
        assert offset == pytest.approx(HAND[missing])


@pytest.mark.parametrize("hidden", [False, True])
def test_neither_a_gesture_nor_a_hidden_tip_turns_the_mean_hand_afterwards(hidden):
    smoother = make_smoother(SmoothingConfig(method="mean"))
    for k in range(10):
        smoother.smooth(arm(k / 30, offset=(0.02 * k, 0, 0)))
    opened = {"thumb": None} if hidden else {"hand_open": True, "thumb": np.array([0.25, 0.1, 0.02])}
    smoother.smooth(arm(10 / 30, offset=(0.2, 0, 0), **opened))
    closed = smoother.smooth(arm(11 / 30, offset=(0.22, 0, 0)))
    for tip in ("index", "thumb"):
        assert getattr(closed, tip) - closed.wrist == pytest.approx(HAND[tip])


@pytest.mark.parametrize("method", METHODS)
def test_after_a_loss_nothing_old_is_mixed_in(method):
    smoother = make_smoother(SmoothingConfig(method=method))
    for k in range(10):
        smoother.smooth(arm(k / 30))
    lost = ArmEstimate(t_ns=round(10 / 30 * NS_PER_S), status=TrackingStatus.LOST, reason="no arm")
    assert smoother.smooth(lost) is lost
    back = smoother.smooth(arm(11 / 30, offset=(0.4, 0, 0), turn=(0.5, 0, 0)))
    for name in POINTS:
        assert getattr(back, name) == pytest.approx(getattr(arm(0.0, offset=(0.4, 0, 0), turn=(0.5, 0, 0)), name))


@pytest.mark.parametrize("method", METHODS)
def test_after_a_gap_in_time_nothing_old_is_mixed_in(method):
    smoother = make_smoother(SmoothingConfig(method=method))
    smoother.smooth(arm(0.0))
    back = smoother.smooth(arm(2.0, offset=(0.4, 0, 0)))
    assert back.wrist == pytest.approx([0.4, 0, 0])
    assert back.index == pytest.approx(HAND["index"] + [0.4, 0, 0])


@pytest.mark.parametrize("method", METHODS)
def test_a_gap_of_200_ms_is_none_yet(method):
    smoother = make_smoother(SmoothingConfig(method=method))
    smoother.smooth(arm(0.0))
    assert 0.0 < present(smoother.smooth(arm(0.2, offset=(0.1, 0, 0))).wrist)[0] < 0.1


def test_everything_but_the_points_is_kept():
    estimate = arm(0.0, status=TrackingStatus.DEGRADED)
    smooth = make_smoother(SmoothingConfig()).smooth(estimate)
    assert (smooth.t_ns, smooth.status, smooth.reason) == (estimate.t_ns, estimate.status, estimate.reason)


def test_the_filters_do_not_care_about_the_frame_rate_at_rest():
    def noise_left(fps):
        rng = np.random.default_rng(5)
        smooth = run("one_euro", lambda t_s: arm(t_s, noise=0.002, rng=rng), 900, fps=fps)
        return np.array([e.wrist for e in smooth[100:]]).std(axis=0).mean()

    assert noise_left(60.0) < noise_left(30.0) < 0.0011
