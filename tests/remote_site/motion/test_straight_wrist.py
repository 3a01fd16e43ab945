"""A hand that turns and moves through a straight wrist: the tool keeps to its path, also where the arm is slowed."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from common.geometry import Array, rotation_from_vector, transform
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.target_tracker import choose_target_tracker
from remote_site.motion.tool_sample import ToolSample
from tests.remote_site.arms_followed import SAMPLE_TICKS, smooth
from tests.remote_site.remote_loop import TICK_NS, arm

DT = TICK_NS / 1e9
STRAIGHT = (0.0, 10.0, -70.0, 0.0, -2.0, 0.0)
BENT = (0.0, 10.0, -70.0, 0.0, -20.0, 0.0)
ROLLED = (6.4, -0.5, -73.2, -58.4, -18.9, 56.4)  # as an arm stood that left its path by 63 mm, and met the table
BEFORE_S, WAIT_S, AFTER_S = 0.3, 0.3, 4.0
MOST_M = 0.014  # beside its way; without pacing and waiting, up to 117 mm
WILDEST_M = 0.04  # of the random ways; all but one within 9 mm
REST_M = 0.005  # after AFTER_S; at 0.3 of full speed the last millimetres take some seconds more
BEYOND = 0.1  # of a leg: where the hand turns sharply, a prediction goes on

Speed = Callable[[float], float]


class Way:
    """The tool's places and turns from the start, (n, 6) in m and rad in the base's axes, and when it is there."""

    def __init__(self, *places: tuple[float, ...], seconds: tuple[float, ...]) -> None:
        self.places = np.array([np.zeros(6), *places])
        self.times = BEFORE_S + np.cumsum([0.0, *seconds])
        self.seconds = float(self.times[-1]) + AFTER_S

    def at(self, t: float) -> Array:
        """The place and turn (6,) at a time."""
        leg = min(max(int(np.searchsorted(self.times, t)) - 1, 0), len(self.places) - 2)
        part = smooth((t - self.times[leg]) / (self.times[leg + 1] - self.times[leg]))
        place: Array = self.places[leg] + part * (self.places[leg + 1] - self.places[leg])
        return place

    def beside(self, tools: Array) -> Array:
        """How far tools' places (n, 3) from the start are in m from the nearest leg, or a little further on."""
        off = []
        for begin, end in pairwise(self.places[:, :3]):
            way = end - begin
            part = np.clip((tools - begin) @ way / max(float(way @ way), 1e-12), -BEYOND, 1.0 + BEYOND)
            off.append(np.linalg.norm(tools - begin - part[:, None] * way, axis=1))
        nearest: Array = np.min(off, axis=0)
        return nearest


def there_and_back(place: tuple[float, ...], seconds: float) -> Way:
    """To a place, and back after a wait."""
    return Way(place, place, (0.0,) * 6, seconds=(seconds, WAIT_S, seconds))


def random_way(seed: int) -> Way:
    """Four places within 5 cm and 0.35 rad of the start, each leg no quicker than 0.2 m/s and 1 rad/s, and back."""
    rng = np.random.default_rng(seed)
    places = [np.zeros(6), *(np.append(rng.uniform(-0.05, 0.05, 3), rng.uniform(-0.35, 0.35, 3)) for _ in range(4))]
    places.append(np.zeros(6))
    steps = [(float(np.linalg.norm((b - a)[:3])), float(np.linalg.norm((b - a)[3:]))) for a, b in pairwise(places)]
    seconds = tuple(max(way_m / 0.2, turn_rad, 0.3) for way_m, turn_rad in steps)
    return Way(*(tuple(place) for place in places[1:]), seconds=seconds)


def tool_after(way: Way, start_deg: tuple[float, ...], sampled: Speed, slowed: Speed) -> Array:
    """The tool's places (n, 3) in m from its start.

    `sampled` is the fraction of full speed that is said with each sample, `slowed` that at which the arm follows.
    """
    config = RemoteConfig(robot=RobotConfig(start_deg=start_deg))
    model, limits = arm(config)
    tracker = choose_target_tracker(config.robot, config.control, model, limits)
    joints, sent = JerkLimitedTracker(limits, DT), JointMotion.at_rest(config.robot.start)
    start, tools = model.forward(sent.q).copy(), []
    tracker.reset(0, sent.q)
    for k in range(1, round(way.seconds / DT)):
        now_ns, t = k * TICK_NS, k * DT
        if k % SAMPLE_TICKS == 0:
            place = way.at(t)
            base_T_target = transform(rotation_from_vector(place[3:]) @ start[:3, :3], start[:3, 3] + place[:3])
            sample = ToolSample(now_ns, now_ns, base_T_target, None, None, stretch=1 / sampled(t), speed=sampled(t))
            assert tracker.aim(sample) is None
        joints.reset(sent)
        motion = joints.track(tracker.at(now_ns, sent, slowed(t)), slowed(t))
        assert isinstance(motion, JointMotion)
        sent = motion
        tools.append(model.forward(sent.q)[:3, 3] - start[:3, 3])
    return np.array(tools)


def always(speed: float) -> Speed:
    return lambda _t: speed


def assert_kept_to(way: Way, tools: Array, most_m: float = MOST_M) -> None:
    assert way.beside(tools).max() < most_m
    assert np.linalg.norm(tools[-1]) < REST_M


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.3, 0.5, 0.66, 0.8, 1.0])
@pytest.mark.parametrize(
    ("start_deg", "turn"),
    [
        (STRAIGHT, (0.6, 0.0, 0.0)),
        (STRAIGHT, (0.0, 0.6, 0.0)),
        (STRAIGHT, (0.0, 0.0, 0.6)),
        (BENT, (0.0, 0.0, 0.6)),
        (ROLLED, (0.0, 0.6, 0.0)),
        (ROLLED, (0.0, 0.0, 0.6)),
    ],
)
def test_a_tool_that_turns_through_the_straight_wrist_stays_in_its_place(
    start_deg: tuple[float, ...], turn: tuple[float, ...], speed: float
) -> None:
    way = there_and_back((0.0, 0.0, 0.0, *turn), 0.8)
    assert_kept_to(way, tool_after(way, start_deg, always(speed), always(speed)))


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.3, 0.66])
@pytest.mark.parametrize("seconds", [0.6, 1.0])
@pytest.mark.parametrize(
    "place", [(0.0, 0.15, 0.0, 0.0, 0.0, 0.0), (-0.05, 0.12, 0.03, 0.1, 0.4, 0.6), (0.05, -0.12, 0.05, 0.3, -0.4, -0.6)]
)
def test_a_tool_that_is_carried_through_the_straight_wrist_keeps_to_its_line(
    place: tuple[float, ...], seconds: float, speed: float
) -> None:
    way = there_and_back(place, seconds)
    assert_kept_to(way, tool_after(way, BENT, always(speed), always(speed)))


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.3, 0.5, 0.8])
@pytest.mark.parametrize("seed", range(3))
def test_random_ways_about_the_straight_wrist_are_kept_to(seed: int, speed: float) -> None:
    way = random_way(seed)
    assert_kept_to(way, tool_after(way, ROLLED, always(speed), always(speed)), WILDEST_M)


@pytest.mark.slow
@pytest.mark.parametrize("slowed", [0.3, 0.6])
@pytest.mark.parametrize("start_deg", [STRAIGHT, BENT, ROLLED])
def test_an_arm_that_is_slowed_under_way_keeps_to_its_path(start_deg: tuple[float, ...], slowed: float) -> None:
    """As by an obstacle or a singular posture that is near, of which the samples know nothing."""
    way = there_and_back((0.0, 0.0, 0.0, 0.0, 0.0, 0.6), 0.8)
    assert_kept_to(way, tool_after(way, start_deg, always(1.0), lambda t: slowed if t > 0.6 else 1.0))
