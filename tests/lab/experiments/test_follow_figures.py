"""Lag and residual of curves that are known, and how poses become curves."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import rotation_from_vector, transform
from lab.experiments.follow_figures import (
    Curves,
    follow_figures,
    gripper_figures,
    hand_rows,
    rows_at,
    tool_rows,
    with_closed_hand,
)

BASE_R_OPERATOR = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
AHEAD = np.array([-0.12, 0.0, 0.08])
FRAMES_NS = np.arange(0, 10 * NS_PER_S, NS_PER_S // 30, dtype=np.int64)
TRUTH_NS = np.arange(0, 11 * NS_PER_S, 10 * NS_PER_MS, dtype=np.int64)


def motion(times_ns):
    """A hand that moves and turns smoothly, at rest before the start."""
    t = np.maximum(np.asarray(times_ns) / NS_PER_S, 0.0)
    swell = 1.0 - np.exp(-(t**2))
    return np.column_stack([a * swell * np.sin(w * t) for a, w in ((80, 1), (50, 1.7), (30, 2.3), (12, 1.3), (9, 2))])


def curves(lag_ms, offset=0.0, missing=()):
    measured = motion(FRAMES_NS)
    measured[list(missing)] = np.nan
    tool = motion(FRAMES_NS - lag_ms * NS_PER_MS) + offset
    gripper_mm, hand_open = np.full(len(FRAMES_NS), np.nan), np.zeros(len(FRAMES_NS), bool)
    return Curves(FRAMES_NS, motion(FRAMES_NS), measured, tool, TRUTH_NS, motion(TRUTH_NS), gripper_mm, hand_open)


@pytest.mark.parametrize("lag_ms", [0.0, 70.0, 800.0])
def test_a_late_tool_has_its_lag_and_nothing_left(lag_ms):
    figures = follow_figures(curves(lag_ms), 0)
    for hand in ("tool_behind_true_hand", "tool_behind_measured_hand"):
        behind = figures[hand]
        assert behind["lag_ms"] == pytest.approx(lag_ms, abs=2.0)
        assert behind["angle_lag_ms"] == pytest.approx(lag_ms, abs=2.0)
        assert behind["residual_mm"]["max"] < 0.2
        assert behind["residual_deg"]["xy_deg"]["max"] < 0.05
    apart = figures["tool_behind_true_hand"]["apart_at_the_same_instant"]["mm"]["mean"]
    assert apart == pytest.approx(0.0, abs=0.05) if lag_ms == 0 else apart > 3.0


def test_an_offset_is_left_over_but_makes_no_lag():
    behind = follow_figures(curves(120.0, offset=np.array([3.0, 0.0, -4.0, 2.0, 0.0])), 0)["tool_behind_true_hand"]
    assert behind["lag_ms"] == pytest.approx(120.0, abs=2.0)
    assert behind["residual_mm"]["mean"] == pytest.approx(5.0, abs=0.05)
    assert behind["residual_by_axis_mm"] == pytest.approx({"x": 3.0, "y": 0.0, "z": 4.0}, abs=0.05)
    assert behind["residual_deg"]["xy_deg"]["mean"] == pytest.approx(2.0, abs=0.05)


def test_frames_without_a_hand_are_counted_and_bridged():
    figures = follow_figures(curves(70.0, missing=range(100, 103)), 0)
    assert figures["frames_without_hand"] == 3
    assert figures["tool_behind_measured_hand"]["lag_ms"] == pytest.approx(70.0, abs=2.0)
    assert figures["tool_behind_measured_hand"]["residual_mm"]["max"] < 2.0


def test_only_frames_of_the_motion_count():
    assert follow_figures(curves(0.0), 5 * NS_PER_S)["frames"] == 150


def test_a_tool_that_moves_as_the_hand_has_the_same_rows():
    turns = [rotation_from_vector(np.radians([0.0, pitch, yaw])) for pitch, yaw in ((0, 0), (5, -20), (-15, 30))]
    places = np.array([[0.0, 0.0, 0.0], [0.1, -0.2, 0.05], [-0.3, 0.1, -0.1]])
    start = transform(rotation_from_vector(np.array([0.3, 1.2, -0.5])), np.array([0.4, 0.1, 0.6]))
    poses = [
        transform(BASE_R_OPERATOR @ turn @ BASE_R_OPERATOR.T @ start[:3, :3], start[:3, 3] + 2.0 * BASE_R_OPERATOR @ at)
        for turn, at in zip(turns, places, strict=True)
    ]
    hand = hand_rows(places, np.array([turn @ AHEAD for turn in turns]), np.zeros(3), AHEAD)
    np.testing.assert_allclose(tool_rows(np.array(poses), BASE_R_OPERATOR, 2.0, AHEAD), hand, atol=1e-9)
    assert hand[1, 3] == pytest.approx(-20.0, abs=1.0)
    assert hand[0] == pytest.approx(np.zeros(5))


def test_rows_between_times_leave_gaps_out():
    rows = np.array([[0.0] * 5, [np.nan] * 5, [2.0] * 5])
    np.testing.assert_allclose(rows_at(np.array([1.0]), np.array([0.0, 1.0, 2.0]), rows), [[1.0] * 5])


def test_an_open_hand_has_the_direction_between_those_of_the_closed_one():
    rows = np.array([[1.0, 2.0, 3.0, 10.0, -10.0], [4.0, 5.0, 6.0, 77.0, 88.0], [7.0, 8.0, 9.0, 20.0, -20.0]])
    closed = with_closed_hand(rows, np.array([True, False, True]))
    np.testing.assert_allclose(closed[:, :3], rows[:, :3])
    np.testing.assert_allclose(closed[:, 3:], [[10.0, -10.0], [15.0, -15.0], [20.0, -20.0]])


def test_a_gripper_that_is_not_measured_has_no_figures():
    openings_mm = {"at_first": 65.0, "least": 49.9, "in_the_end": 64.0}
    assert gripper_figures(np.array([65.0, 49.9, 64.0])) == {"gripper_mm": openings_mm}
    assert gripper_figures(np.full(3, np.nan)) == {}
