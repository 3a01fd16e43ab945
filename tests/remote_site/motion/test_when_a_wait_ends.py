"""When a joint target waits and when it is handed back: near enough, slow enough, and where no sample leads on."""

import math

import numpy as np
import pytest

from common.geometry import Array
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.waiting_target import DecayingOffset, WaitingTarget
from tests.remote_site.motion.test_waiting_target import DT, ELBOW, LIMITS, MODEL, SHOULDER, START, WRIST_ROLL, Way
from tests.remote_site.remote_loop import TICK_NS

BASE = np.eye(6)[0]
NEARLY_STRAIGHT = np.radians([0.0, -20.0, -15.0, 0.0, -45.0, 0.0])


@pytest.fixture
def late() -> Way:
    """A hand that was too fast and stands now; the arm is where its target waits."""
    way = Way(ELBOW)
    way.go(0.0, 0.0, ticks=8)
    way.go(0.0, 4.0, ticks=40)
    way.go(0.64, 0.0, ticks=16)
    assert way.waiting.waits
    return way


def sideways(way: Way, rad: float) -> None:
    """Let the target come to the end of its path, for an arm that is led by so much beside it."""
    for _ in range(200):
        target = JointMotion.at_rest(START + 0.64 * ELBOW)
        motion = way.waiting.follow(way.ticks * TICK_NS, target, way.sent, 1.0)
        way.sent = JointMotion(motion.q + rad * SHOULDER, motion.dq, motion.ddq)
        way.ticks += 1


def test_a_target_at_the_end_of_its_path_waits_until_the_tool_is_there(late: Way) -> None:
    sideways(late, 0.003)
    assert late.waiting.waits
    sideways(late, 0.0)
    assert not late.waiting.waits


def test_a_hand_that_goes_on_faster_than_a_slowed_arm_may_is_waited_for_all_the_time() -> None:
    waiting, there, rad = WaitingTarget(MODEL, LIMITS, DT), JointMotion.at_rest(START), 0.0
    waits = []
    for k in range(60):
        target = JointMotion(START + rad * ELBOW, 0.24 * LIMITS.velocity[2] * ELBOW, np.zeros(6))
        if k % 8 == 0:
            waiting.add(target.q, k * TICK_NS)
        there = waiting.follow(k * TICK_NS, target, there, 0.2)
        waits.append(waiting.waits)
        rad += 0.24 * LIMITS.velocity[2] * DT
    assert all(waits)


def test_what_the_wrists_roll_is_off_counts_little_when_a_wait_ends(late: Way) -> None:
    for _ in range(600):
        target = JointMotion.at_rest(START + 0.64 * ELBOW + 0.2 * WRIST_ROLL)
        late.sent = late.waiting.follow(late.ticks * TICK_NS, target, late.sent, 1.0)
        late.ticks += 1
    assert not late.waiting.waits
    assert late.sent.q[3] - START[3] == pytest.approx(0.2, abs=1e-3)


def test_a_target_of_which_no_sample_has_come_yet_stands_too_for_a_tool_that_does_not_follow() -> None:
    waiting, there = WaitingTarget(MODEL, LIMITS, DT), JointMotion.at_rest(START)
    for k in range(100):
        target = JointMotion(START + 4.0 * k * DT * ELBOW, 4.0 * ELBOW, np.zeros(6))
        motion = waiting.follow(k * TICK_NS, target, there, 1.0)
    assert motion.q[2] - START[2] < 0.05
    assert motion.dq[2] == pytest.approx(0.0, abs=0.05)


def test_a_prediction_leads_no_further_than_the_last_place_that_the_arm_can_reach(late: Way) -> None:
    late.waiting.halt(START + 0.64 * ELBOW)
    for k in range(200):
        target = JointMotion(START + (0.64 + k * DT) * ELBOW, ELBOW, np.zeros(6))
        late.sent = late.waiting.follow(late.ticks * TICK_NS, target, late.sent, 1.0)
        late.ticks += 1
        assert (late.sent.q - START)[2] < 0.65


def test_a_hand_that_is_in_reach_again_is_caught_up_with() -> None:
    way = Way(BASE)
    way.go(0.0, 0.0, ticks=8)
    way.go(0.0, 4.0, ticks=6)
    way.waiting.halt(START + 0.096 * BASE)
    way.go(0.096, 0.6, ticks=300)
    assert not way.waiting.waits
    assert way.places()[-1] == pytest.approx(0.096 + 299 * 0.6 * DT, abs=0.01)


@pytest.mark.parametrize(("behind_m", "waits"), [(0.0, False), (0.001, False), (0.002, True)])
def test_where_joints_cancel_each_other_a_tool_a_little_behind_counts_as_beside_its_way(
    behind_m: float, waits: bool
) -> None:
    dq = stretching(0.02)
    target = JointMotion(NEARLY_STRAIGHT, dq, np.zeros(6))
    waiting = WaitingTarget(MODEL, LIMITS, DT)
    waiting.follow(0, target, JointMotion(NEARLY_STRAIGHT - behind_m / 0.02 * dq, dq, np.zeros(6)), 1.0)
    assert waiting.waits is waits


def stretching(m_s: float) -> Array:
    """The joints' speeds (6,) in rad/s that move the tool so fast where it is hardest, and do not turn it."""
    jacobian = MODEL.jacobian(NEARLY_STRAIGHT)
    hardest = np.linalg.svd(jacobian[:3, :3])[0][:, 2]
    dq: Array = np.linalg.solve(jacobian, np.concatenate([m_s * hardest, np.zeros(3)]))
    return dq


def test_no_joint_accelerates_harder_on_a_bend_than_it_can_and_the_target_says_how_hard() -> None:
    """An elbow that is too fast, and a shoulder that is from one sample to the next."""
    waiting, there = WaitingTarget(MODEL, LIMITS, DT), JointMotion.at_rest(START)
    motions, part = [], np.zeros(6)
    for k in range(400):
        dq = np.zeros(6) if k >= 100 else 4.0 * (ELBOW if k < 30 else SHOULDER if k < 60 else -ELBOW)
        if k % 8 == 0:
            waiting.add(START + part, k * TICK_NS)
        there = waiting.follow(k * TICK_NS, JointMotion(START + part, dq, np.zeros(6)), there, 1.0)
        motions += [there] if waiting.waits and k > 0 else []
        part = part + dq * DT
    gained = np.diff([motion.dq for motion in motions], axis=0) / DT
    said = np.array([motion.ddq for motion in motions])
    assert (np.abs(gained) < 1.05 * LIMITS.acceleration).all()
    assert np.abs(gained - said[:-1]).max() < 3.0


def test_what_is_left_when_a_wait_ends_decays_in_some_tenths_of_a_second() -> None:
    offset = DecayingOffset(lambda wanted, _off, _dq_off: wanted, DT)
    target = JointMotion.at_rest(START)
    offset.begin(JointMotion.at_rest(START + 0.05 * ELBOW), target)
    left = [offset.added_to(target).q[2] - START[2] for _ in range(250)]
    assert left[24] == pytest.approx(0.05 * 2 / math.e, abs=1e-4)
    assert left[-1] == pytest.approx(0.0, abs=1e-4)
    assert left == sorted(left, reverse=True)
