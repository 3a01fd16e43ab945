"""The path of the joints over solutions: smooth, slower where it bends, and smooth whatever the samples' noise."""

import math
from itertools import pairwise

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import Array
from remote_site.motion.joint_path import PLANNED, JointPath, on_the_curve
from tests.remote_site.motion.test_waiting_target import ELBOW, LIMITS, MODEL, START


def bent(turn: float) -> JointPath:
    """A path that leaves its direction by so much (rad)."""
    path = JointPath(MODEL, LIMITS)
    path.begin(START, 0, 0.0, ELBOW, 0.0)
    for k, direction in enumerate([ELBOW, np.array([0.0, math.sin(turn), math.cos(turn), 0.0, 0.0, 0.0])]):
        path.add(path.knots[-1].q + 0.05 * direction, (k + 1) * 10 * NS_PER_MS)
    return path


def along(path: JointPath, steps: int) -> tuple[Array, Array, Array, Array]:
    """The path's s (n,), its joints (n, 6) there, dq/ds and d²q/ds², as many for each segment."""
    segments = list(pairwise(path.knots))
    s = np.concatenate([np.linspace(a.s, b.s, steps, endpoint=False) for a, b in segments])
    found = [on_the_curve(*segments[k // steps], at) for k, at in enumerate(s.tolist())]
    q, slope, bend = (np.array(column) for column in zip(*found, strict=True))
    return s, q, slope, bend


@pytest.mark.parametrize("turn", [0.1, 0.5, 1.5])
def test_the_path_is_smooth_and_its_slope_and_bend_are_what_they_are_said_to_be(turn: float) -> None:
    s, q, slope, bend = along(bent(turn), 200)
    ds = np.diff(s)[:, None]
    assert np.allclose(np.diff(q, axis=0) / ds, (slope[1:] + slope[:-1]) / 2, atol=1e-3)
    assert np.allclose(np.diff(slope, axis=0) / ds, bend[:-1], atol=0.03 * np.abs(bend).max())
    assert np.abs(np.diff(slope, axis=0)).max() < 0.05 * np.abs(slope).max()  # no corner


def test_the_sharper_a_bend_the_slower_it_is_taken() -> None:
    bends = [min(knot.bend for knot in bent(turn).knots) for turn in (0.1, 0.5, 1.5)]
    assert bends[0] > bends[1] > bends[2]


@pytest.mark.parametrize("joint", range(6))
def test_no_joint_is_planned_to_accelerate_harder_than_it_can(joint: int) -> None:
    path = JointPath(MODEL, LIMITS)
    assert path.gain(np.eye(6)[joint]) == pytest.approx(PLANNED * LIMITS.acceleration[joint])


def test_a_hand_that_stands_adds_no_places_and_what_comes_after_counts_from_now() -> None:
    path = bent(0.5)
    last = path.knots[-1]
    for k in range(50):
        path.add(last.q + 1e-5 * (k % 2), (30 + 10 * k) * NS_PER_MS)
    assert len(path.knots) == 3
    path.add(last.q + 0.2 * ELBOW, 530 * NS_PER_MS)
    assert path.knots[-1].own > 0.5  # of full speed: from where it stood a moment ago, not when it came there


def test_a_path_that_is_far_behind_is_smooth_whatever_the_samples_noise() -> None:
    rng, step_ms = np.random.default_rng(3), 16
    path = JointPath(MODEL, LIMITS)
    path.begin(START, 0, 0.0, ELBOW, 0.0)
    for k in range(1, 60):
        path.add(START + 0.01 * k * ELBOW + 0.002 * rng.standard_normal(6), k * step_ms * NS_PER_MS)
    knots = list(path.knots)
    soon = [knot.bend for knot in knots[1:] if knot.t_ns <= 100 * NS_PER_MS]
    later = [knot.bend for knot in knots[1:-1] if knot.t_ns > 250 * NS_PER_MS]
    assert np.median(later) > 4 * np.median(soon)
    assert knots[-1].q[2] - START[2] == pytest.approx(0.59, abs=0.06)
