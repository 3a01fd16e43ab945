"""A joint target that waits: on the hand's path, no faster than the joints, and not where nothing asks for it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.tool_shift import ToolShift
from remote_site.motion.waiting_target import HELD_S, WaitingTarget
from tests.remote_site.remote_loop import TICK_NS, arm

DT = TICK_NS / 1e9
MODEL, LIMITS = arm()
START = RemoteConfig().robot.start
BENT = START + np.radians([0.0, 0.0, -45.0, 0.0, 0.0, 0.0])
SHOULDER, ELBOW, WRIST_ROLL = np.eye(6)[[1, 2, 3]]
SAMPLE_TICKS = 8


class Way:
    """A hand's way along one direction of the joints, and the target that an arm follows exactly, or not at all."""

    def __init__(self, direction: Array, start: Array = START) -> None:
        self.waiting, self.direction, self.start = WaitingTarget(MODEL, LIMITS, DT), direction, start
        self.sent, self.ticks = JointMotion.at_rest(start), 0
        self.motions: list[JointMotion] = []

    def go(self, rad: float, rad_s: float, *, ticks: int = 1, follows: bool = True, barred: bool = False) -> None:
        """The hand is at `rad` along the direction, moving, for so many ticks."""
        for _ in range(ticks):
            now_ns = self.ticks * TICK_NS
            if self.ticks % SAMPLE_TICKS == 0:
                self.waiting.add(self.start + rad * self.direction, now_ns)
            target = JointMotion(self.start + rad * self.direction, rad_s * self.direction, np.zeros(6))
            motion = self.waiting.follow(now_ns, target, self.sent, 1.0, barred=barred)
            self.motions.append(motion)
            self.sent = motion if follows else self.sent
            self.ticks += 1
            rad += rad_s * DT

    def places(self) -> Array:
        """Where the target was along the direction (n,) in rad."""
        return np.array([(motion.q - self.start) @ self.direction for motion in self.motions])


@pytest.fixture
def elbow() -> Way:
    return Way(ELBOW)


def test_a_target_that_the_joints_can_follow_passes_as_it_is(elbow: Way) -> None:
    elbow.go(0.0, 0.2, ticks=100)
    assert not elbow.waiting.waits
    assert np.allclose(elbow.places(), 0.2 * DT * np.arange(100))


def test_a_target_faster_than_the_joints_is_late_on_its_way_and_no_joint_brakes_harder_than_it_can(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    elbow.go(0.0, 4.0, ticks=40)  # more than the joint's own 3.14 rad/s
    assert elbow.waiting.waits
    elbow.go(40 * 4.0 * DT, 0.0, ticks=400)
    places = elbow.places()
    speeds = np.diff(places[9:]) / DT
    assert speeds.max() < LIMITS.velocity[2]
    assert np.abs(np.diff(speeds)).max() < 1.05 * LIMITS.acceleration[2] * DT
    assert places.max() < 40 * 4.0 * DT + 0.01
    assert places[-1] == pytest.approx(40 * 4.0 * DT, abs=1e-3)
    assert not elbow.waiting.waits


def test_a_bent_elbow_is_not_waited_for() -> None:
    way = Way(-ELBOW, BENT)
    way.go(0.0, 0.0, ticks=8)
    way.go(0.0, 4.0, ticks=40, follows=False)
    assert not way.waiting.waits
    assert way.places()[-1] == pytest.approx(39 * 4.0 * DT)


@pytest.mark.parametrize(("rad_s", "start", "waits"), [(0.2, START, False), (0.7, START, True), (0.7, BENT, False)])
def test_a_tool_beside_its_way_is_waited_for_where_it_is_quick_and_the_elbow_not_bent(
    rad_s: float, start: Array, waits: bool
) -> None:
    waiting = WaitingTarget(MODEL, LIMITS, DT)
    beside = JointMotion.at_rest(start + 0.02 * SHOULDER)
    waiting.follow(0, JointMotion(start, rad_s * ELBOW, np.zeros(6)), beside, 1.0)
    assert waiting.waits is waits


@pytest.mark.parametrize(
    ("joint", "bend_deg", "waits"), [(3, -30, True), (3, -2, False), (4, -30, False), (2, -30, False)]
)
def test_a_wrist_whose_roll_lags_and_takes_the_tool_out_of_its_place_is_waited_for_though_the_elbow_is_bent(
    joint: int, bend_deg: float, waits: bool
) -> None:
    posture = np.radians([0.0, 10.0, -95.0, 0.0, bend_deg, 0.0])
    waiting = WaitingTarget(MODEL, LIMITS, DT)
    lag_rad = 0.1 if joint > 2 else 0.02
    waiting.follow(0, JointMotion.at_rest(posture), JointMotion.at_rest(posture - lag_rad * np.eye(6)[joint]), 1.0)
    assert waiting.waits is waits


def test_a_roll_that_lags_while_the_tool_is_in_its_place_is_not_waited_for() -> None:
    """As beside an obstacle, where such waits began and ended in every tick."""
    posture = np.radians([0.0, 10.0, -95.0, 0.0, -30.0, 0.0])
    roll = 0.1 * np.eye(6)[3]
    lever = MODEL.jacobian(posture - roll)[:3]
    roll[:3] = -np.linalg.solve(lever[:, :3], lever @ roll)
    waiting = WaitingTarget(MODEL, LIMITS, DT)
    waiting.follow(0, JointMotion.at_rest(posture), JointMotion.at_rest(posture - roll), 1.0)
    assert not waiting.waits


def test_what_the_hand_goes_back_and_forth_is_gone_after_it_and_not_cut_short(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    elbow.go(0.0, 4.0, ticks=40)
    elbow.go(0.64, -4.0, ticks=40)
    elbow.go(0.0, 0.0, ticks=600)
    assert elbow.places().max() == pytest.approx(0.64, abs=0.05)
    assert elbow.places()[-1] == pytest.approx(0.0, abs=1e-3)


def test_a_target_that_waits_for_the_tool_stands_until_it_comes_then_gives_up(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    elbow.go(0.0, 4.0, ticks=40, follows=False)
    place = elbow.places()[-1]
    assert place < 0.2
    held = round(HELD_S / DT)
    elbow.go(0.64, 0.0, ticks=held - 45, follows=False)
    assert elbow.places()[-1] == pytest.approx(place, abs=0.05)
    elbow.go(0.64, 0.0, ticks=400, follows=False)
    assert elbow.places()[-1] > 0.6


def test_a_barred_target_does_not_wait(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    elbow.go(0.0, 4.0, ticks=40, follows=False, barred=True)
    assert not elbow.waiting.waits
    elbow.go(0.64, 0.0, follows=False)
    assert elbow.waiting.waits
    elbow.go(0.64, 0.0, ticks=2, follows=False, barred=True)
    assert not elbow.waiting.waits


def test_a_hand_out_of_reach_is_led_to_the_last_solution_and_no_further(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    elbow.go(0.0, 4.0, ticks=4)
    elbow.waiting.halt(START + 0.3 * elbow.direction)
    for k in range(200):
        target = JointMotion.at_rest(START + 0.8 * elbow.direction)  # a prediction that no sample bears out
        elbow.sent = elbow.waiting.follow((12 + k) * TICK_NS, target, elbow.sent, 1.0)
        assert (elbow.sent.q - START) @ elbow.direction < 0.31
    assert (elbow.sent.q - START) @ elbow.direction == pytest.approx(0.3, abs=0.01)


@pytest.mark.parametrize("rad_s", [3.0, 5.0])
def test_a_path_that_turns_at_joints_limits_does_not_swing_beyond_them_nor_what_comes_after_it(rad_s: float) -> None:
    limits = replace(LIMITS, lower=START - 0.1, upper=START + 0.1)
    waiting, there, furthest = WaitingTarget(MODEL, limits, DT), JointMotion.at_rest(START), [[0.0], [0.0]]
    for k in range(500):
        swings = 0.3 * np.array([0.0, math.sin(0.7 * rad_s * k * DT), math.sin(rad_s * k * DT), 0.0, 0.0, 0.0])
        speeds = 0.3 * rad_s * np.array([0.0, 0.7 * math.cos(0.7 * rad_s * k * DT), math.cos(rad_s * k * DT), 0, 0, 0])
        inside = np.abs(swings) < 0.1
        target = JointMotion(np.clip(START + swings, limits.lower, limits.upper), inside * speeds, np.zeros(6))
        if k % SAMPLE_TICKS == 0:
            waiting.add(target.q, k * TICK_NS)
        there = waiting.follow(k * TICK_NS, target, there, 0.3)
        furthest[waiting.waits].append(float(np.abs(there.q - START).max()))
    assert [max(places) for places in furthest] == pytest.approx([0.1, 0.1], abs=1e-9)


def test_a_refusal_before_a_wait_slows_no_wait(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    elbow.waiting.halt(START)
    target = JointMotion(START, 4.0 * ELBOW, np.zeros(6))
    for k in range(100):
        elbow.sent = elbow.waiting.follow(k * TICK_NS, target, elbow.sent, 1.0)
    assert elbow.waiting.waits
    assert elbow.sent.dq[2] > 0.4 * LIMITS.velocity[2]


def test_a_prediction_that_turns_back_is_braked_for_first(elbow: Way) -> None:
    elbow.go(0.0, 0.0, ticks=8)
    target = JointMotion(START, 4.0 * ELBOW, np.zeros(6))
    for k in range(20):
        elbow.sent = elbow.waiting.follow(k * TICK_NS, target, elbow.sent, 1.0)
    target = JointMotion(target.q, -1.0 * ELBOW, np.zeros(6))
    before = elbow.sent.dq[2]
    for k in range(20, 60):
        elbow.sent = elbow.waiting.follow(k * TICK_NS, target, elbow.sent, 1.0)
        assert abs(elbow.sent.dq[2] - before) < 2.0 * LIMITS.acceleration[2] * DT
        before = elbow.sent.dq[2]


@pytest.mark.parametrize("speed", [0.3, 0.1])
def test_a_path_is_no_longer_than_a_second_at_the_speed_that_is_allowed(speed: float) -> None:
    waiting, there = WaitingTarget(MODEL, LIMITS, DT), JointMotion.at_rest(START)
    for k in range(2000):
        rad = 0.3 * math.sin(14.0 * k * DT)
        target = JointMotion(START + rad * ELBOW, 4.2 * math.cos(14.0 * k * DT) * ELBOW, np.zeros(6))
        if k % SAMPLE_TICKS == 0:
            waiting.add(target.q, k * TICK_NS)
        there = waiting.follow(k * TICK_NS, target, there, speed)
    assert waiting.waits
    assert 0.05 < waiting.ahead_s < speed + 0.05


def test_an_arm_that_stands_straight_up_is_stretched() -> None:
    assert ToolShift(MODEL).stretch(np.zeros(6)) == math.inf
