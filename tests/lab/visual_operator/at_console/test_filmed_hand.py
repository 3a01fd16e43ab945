"""The hand before the cameras: its path goes out in time, and what has gone out is never changed."""

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from lab.visual_operator.at_console.filmed_hand import AHEAD_NS, FilmedHand
from lab.visual_operator.hand import Motor, ScriptedHand

START_NS = 5 * NS_PER_S
STEADY = Motor(noise_m=0.0, noise_rad=0.0)
SHIFT, NO_TURN = np.array([0.1, 0.0, 0.0]), np.eye(3)


def taken(hand, *times_s):
    return [pose for t_s in times_s for pose in hand.take(START_NS + round(t_s * NS_PER_S))]


def test_the_poses_are_those_of_the_scripted_hand_a_little_ahead_of_time():
    hand, scripted = FilmedHand(Motor(), 3, START_NS), ScriptedHand(Motor(), 3)
    poses = taken(hand, 0.0, 0.05, 0.1)
    assert np.diff([pose.t_ns for pose in poses]).tolist() == [10 * NS_PER_MS] * (len(poses) - 1)
    assert poses[0].t_ns == START_NS
    assert 0 <= poses[-1].t_ns - START_NS - 100 * NS_PER_MS - AHEAD_NS < 10 * NS_PER_MS
    for pose in poses:
        offset, turn, _ = scripted.at((pose.t_ns - START_NS) / NS_PER_S)
        assert pose.offset == tuple(offset.tolist())
        assert pose.turn == tuple(turn.tolist())


def test_a_late_decision_begins_after_what_is_under_way_and_the_hand_never_jumps():
    hand = FilmedHand(STEADY, 3, START_NS)
    poses = taken(hand, 0.0, 1.0)
    end_s = hand.move(0.3, SHIFT, NO_TURN)
    assert end_s > (poses[-1].t_ns - START_NS) / NS_PER_S
    poses += taken(hand, *np.arange(1.05, end_s + 0.1, 0.05))
    x = np.array([pose.offset[0] for pose in poses])
    assert x[-1] == 0.1
    assert np.abs(np.diff(x)).max() < 0.01 * STEADY.speed_m_s * 1.1


def test_a_decision_in_time_begins_when_it_should():
    hand, scripted = FilmedHand(STEADY, 3, START_NS), ScriptedHand(STEADY, 3)
    taken(hand, 1.0)
    assert hand.move(1.25, SHIFT, NO_TURN) == scripted.move(1.25, SHIFT, NO_TURN)
    assert hand.open_at(3.0) == scripted.open_at(3.0)
    assert [pose.openings for pose in taken(hand, 1.5, 2.0, 2.5, 3.0, 3.5)][-1] == 1


def test_what_came_too_late_is_counted_and_made_up_for():
    hand = FilmedHand(STEADY, 3, START_NS)
    poses = taken(hand, 0.0, 0.05)
    assert hand.late == 0
    poses += taken(hand, 0.5)
    assert hand.late == 1
    assert np.diff([pose.t_ns for pose in poses]).max() == 10 * NS_PER_MS
