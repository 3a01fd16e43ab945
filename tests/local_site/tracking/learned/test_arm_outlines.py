"""The arm that is found belongs to the hand that was seen: at its wrist, and in outlines that hold it."""

from dataclasses import replace

import numpy as np
import pytest

from local_site.tracking.learned.arm_outlines import ArmOutlines
from local_site.tracking.silhouette.arm_finder import NoArm, SeenArm
from local_site.tracking.silhouette.joints import Body
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.landmarks.seen_hands import moved
from tests.local_site.tracking.learned.simulated_landmarks import seen_hand, simulated_landmarks
from tests.local_site.tracking.rendered_arm import rig_of

LIMIT_MM = {"elbow": 25.0, "wrist": 35.0}
UNKNOWN = Body()


def hand_at(sequence, k, by=(0.0, 0.0, 0.0)):
    """The simulated hand as both views see it."""
    return seen_hand(rig_of(sequence.projections), moved(simulated_landmarks(sequence, k), by))


@pytest.fixture
def outlines(moving):
    return ArmOutlines(rig_of(moving.projections))


def test_before_a_dark_wall_the_arm_of_the_hand_is_found(moving, outlines):
    arm = outlines.find(moving.views(3), UNKNOWN, hand_at(moving, 3), starting=True)
    assert isinstance(arm, SeenArm)
    for name, limit_mm in LIMIT_MM.items():
        off = getattr(arm.joints, name) - getattr(moving.truths[3], name)
        assert 1e3 * np.linalg.norm(off) < limit_mm
    assert arm.seen == (0, 1)


def test_it_goes_on_with_the_same_outlines(moving, outlines):
    outlines.find(moving.views(3), UNKNOWN, hand_at(moving, 3), starting=True)
    before = outlines.finder
    assert isinstance(outlines.find(moving.views(4), UNKNOWN, hand_at(moving, 4), starting=False), SeenArm)
    assert outlines.finder is before


@pytest.mark.parametrize("by", [(0.0, 0.0, 0.15), (-0.1, 0.05, 0.05)])
def test_a_hand_elsewhere_does_not_belong_to_the_arm(moving, outlines, by):
    arm = outlines.find(moving.views(3), UNKNOWN, hand_at(moving, 3, by), starting=True)
    assert isinstance(arm, NoArm)
    assert arm.reason


def test_without_an_arm_there_is_a_reason(moving, outlines):
    dark = moving.views(3, lambda pictures: [np.full_like(p, 9) for p in pictures])
    for starting in (True, False):
        arm = outlines.find(dark, UNKNOWN, hand_at(moving, 3), starting=starting)
        assert isinstance(arm, NoArm)
        assert arm.reason


def test_a_room_may_be_learned_before_and_again(moving, outlines):
    empty = moving.views(3, lambda pictures: [np.full_like(p, 9) for p in pictures])
    for _ in range(3):
        outlines.learn_room(empty)
    outlines.forget()
    assert isinstance(outlines.find(moving.views(3), UNKNOWN, hand_at(moving, 3), starting=True), SeenArm)


def test_an_arm_whose_wrist_is_not_the_hands_is_none(moving, outlines):
    outlines.find(moving.views(3), UNKNOWN, hand_at(moving, 3), starting=True)
    arm = outlines.find(moving.views(4), UNKNOWN, hand_at(moving, 4, (0.0, 0.0, 0.1)), starting=False)
    assert arm == NoArm(TrackingReason.NO_ARM)


class Mistaken:
    """A finder of an arm that takes a bend within the forearm for the elbow, until it is told to forget."""

    def __init__(self, arm, begins_anew):
        self._short = replace(arm, joints=replace(arm.joints, elbow=0.5 * (arm.joints.elbow + arm.joints.wrist)))
        self._arm, self._begins_anew, self._found = arm, begins_anew, self._short

    def find(self, *_):
        return self._found

    def forget(self):
        self._found = self._arm if self._begins_anew else self._short


@pytest.mark.parametrize("begins_anew", [True, False])
def test_a_bend_within_the_forearm_is_no_elbow(moving, outlines, monkeypatch, begins_anew):
    hand = hand_at(moving, 3)
    arm = outlines.find(moving.views(3), UNKNOWN, hand, starting=True)
    outlines.finder = Mistaken(arm, begins_anew)
    monkeypatch.setattr(outlines, "_in_room", outlines.finder)
    found = outlines.find(moving.views(3), UNKNOWN, hand, starting=False)
    assert found == (arm if begins_anew else NoArm(TrackingReason.NO_ARM))
