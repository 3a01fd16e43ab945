"""The planner: what it reports as hindrance, and that only what the guard passes goes out."""

from typing import Any

import numpy as np
import pytest

from remote_site.config import RemoteConfig
from remote_site.kinematics.dexterity import FULL, Dexterity, Slowing
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.planner import MotionPlanner
from remote_site.motion.target_tracker import TargetTracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Code, reason
from remote_site.safety.collision_avoidance import CollisionAvoidance
from remote_site.safety.config import CollisionConfig, FixtureConfig, SafetyConfig
from remote_site.safety.guard import Passed
from tests.present import present
from tests.remote_site.remote_loop import TICK_NS, arm, collision_model, guard_of
from tests.remote_site.safety.test_guard import a_wall

DT = TICK_NS / 1e9
CONFIG = RemoteConfig()
MODEL, LIMITS = arm()
START = CONFIG.robot.start
LEASHED = reason(Code.SATURATED, distance_mm=300, limit_mm=200)
UNREACHED = reason(Code.UNREACHED, distance_mm=20, angle_deg=1)
SINGULAR = Slowing(0.5, reason(Code.SINGULAR, condition=100, fraction=0.5))


class Aims(TargetTracker):
    """A target tracker that keeps what it is given, and has a joint target that its test sets."""

    def __init__(self):
        self.aimed, self.unreached, self.q_target = list[Any](), None, None

    def reset(self, t_ns, q):  # noqa: ARG002  # as trackers are reset
        self.q_target = q

    def aim(self, target):
        self.aimed.append(target)
        return self.unreached

    def at(self, now_ns, sent, speed, *, barred=False):  # noqa: ARG002  # as trackers are asked
        return JointMotion.at_rest(present(self.q_target))


class Slows(Dexterity):
    """A dexterity that slows every motion as its test wants."""

    def __init__(self):
        self.answer, self.asked = FULL, 0

    def slowing(self, q, q_target):  # noqa: ARG002  # as dexterity is asked
        self.asked += 1
        return self.answer


class Planning:
    """A planner between a tracker and a dexterity of the test, and the motion that was sent last."""

    def __init__(self, config=CONFIG, box=None):
        self.tracker, self.dexterity, self.guard = Aims(), Slows(), guard_of(config, box)
        avoidance = CollisionAvoidance(collision_model(config), config.safety.collision, LIMITS, DT)
        jerk_limited = JerkLimitedTracker(LIMITS, DT)
        self.planner = MotionPlanner(self.tracker, self.dexterity, avoidance, jerk_limited, self.guard)
        self.sent = JointMotion.at_rest(START)
        self.planner.reset(0, START)

    def aim(self, leashed=None):
        target = ToolSample(0, 0, MODEL.forward(START), None, leashed)
        self.planner.aim(target)
        return target

    def follow(self, ticks=1, aimed=False, speed_scale=1.0):
        for k in range(ticks):
            motion = self.planner.follow(k * TICK_NS, self.sent, speed_scale, aimed=aimed)
            assert isinstance(self.guard.check(motion, self.sent), Passed)
            self.sent = motion


@pytest.fixture
def planning():
    return Planning()


def turned(angle):
    return START + angle * np.eye(6)[0]


@pytest.mark.parametrize(
    ("leashed", "unreached", "expected"),
    [(None, None, None), (LEASHED, None, LEASHED), (None, UNREACHED, UNREACHED), (LEASHED, UNREACHED, LEASHED)],
)
def test_the_leash_hinders_before_the_tracker_which_is_aimed_all_the_same(planning, leashed, unreached, expected):
    planning.tracker.unreached = unreached
    target = planning.aim(leashed)
    assert planning.planner.hindrance is expected
    assert [aimed is target for aimed in planning.tracker.aimed] == [True]


def test_a_hindrance_lasts_until_the_next_target(planning):
    planning.aim(LEASHED)
    planning.follow()
    assert planning.planner.hindrance is LEASHED
    planning.aim()
    assert planning.planner.hindrance is None


def test_dexterity_is_judged_once_for_each_target_in_the_tick_after_it(planning):
    planning.dexterity.answer = SINGULAR
    planning.aim()
    planning.follow(aimed=True)
    assert (planning.dexterity.asked, planning.planner.hindrance) == (0, None)
    planning.follow(3)
    assert (planning.dexterity.asked, planning.planner.hindrance) == (1, SINGULAR.reason)
    planning.aim(LEASHED)
    assert planning.planner.hindrance is LEASHED


def test_a_reset_forgets_target_hindrance_and_slowing(planning):
    planning.dexterity.answer = SINGULAR
    planning.aim()
    planning.follow()
    planning.aim(LEASHED)
    planning.planner.reset(0, turned(0.3))
    assert (planning.tracker.q_target == turned(0.3)).all()
    planning.follow()
    assert (planning.dexterity.asked, planning.planner.hindrance) == (1, None)


def test_an_obstacle_hinders_before_a_singular_posture():
    post = FixtureConfig(name="post", min_m=(0.4, 0.2, 0.0), max_m=(0.5, 0.4, 1.2))
    planning = Planning(RemoteConfig(safety=SafetyConfig(collision=CollisionConfig(fixtures=(post,)))))
    planning.dexterity.answer = SINGULAR
    planning.aim()
    planning.tracker.q_target = turned(0.8)
    codes = []
    for _ in range(100):
        planning.follow()
        codes.append(present(planning.planner.hindrance).code)
    assert codes[0] is Code.SINGULAR
    assert Code.OBSTACLE in codes


@pytest.mark.parametrize("turn", [1.5, 1.51])
@pytest.mark.parametrize("beside_m", [0.15, 0.25])
def test_an_obstacle_is_approached_by_four_times_the_clearance_a_second_and_no_faster(beside_m, turn):
    post = FixtureConfig(name="post", min_m=(0.4, beside_m, 0.0), max_m=(0.5, beside_m + 0.1, 1.2))
    collision = CollisionConfig(fixtures=(post,), slow_m=0.2)
    config = RemoteConfig(safety=SafetyConfig(collision=collision))
    planning, bodies, distances = Planning(config), collision_model(config), []
    planning.tracker.q_target = turned(turn)
    for _ in range(250):
        planning.follow()
        distances.append(
            min(pair.distance for pair in bodies.pairs_within(planning.sent.q, 1.0) if "post" in pair.names)
        )
    approach = -np.diff(distances) / DT
    clearance = np.array(distances[:-1]) - collision.margin_m - 0.004
    # At the edge of what slows it the arm still brakes from the speed at which it came; nearest, rounding counts.
    near = (clearance > 0.005) & (clearance < 0.75 * collision.slow_m)
    assert 3.5 < (approach[near] / clearance[near]).max() < 4.5


def test_dexterity_and_the_allowed_speed_slow_the_arm_together(planning):
    planning.dexterity.answer = SINGULAR
    planning.aim()
    planning.tracker.q_target = turned(1.5)
    planning.follow(150, speed_scale=0.5)
    assert planning.sent.dq[0] == pytest.approx(0.25 * LIMITS.velocity[0], rel=1e-3)


def test_what_the_guard_refuses_becomes_the_stop_with_its_reason():
    planning = Planning(box=a_wall())
    planning.tracker.q_target = turned(0.8)
    planning.sent = JointMotion(START, 0.6 * np.eye(6)[0], np.zeros(6))
    stop = planning.guard.stop(planning.sent)
    planning.follow()
    assert present(planning.planner.hindrance).code is Code.WORKSPACE
    assert (planning.sent.ddq == stop.ddq).all()


def test_without_a_trajectory_the_arm_stops(planning):
    planning.sent = JointMotion(START, 0.6 * np.eye(6)[0], np.zeros(6))
    stop = planning.planner.stop(planning.sent)
    planning.tracker.q_target = turned(np.nan)
    planning.follow()
    assert planning.planner.hindrance.code is Code.NO_TRAJECTORY
    assert (planning.sent.ddq == stop.ddq).all()
