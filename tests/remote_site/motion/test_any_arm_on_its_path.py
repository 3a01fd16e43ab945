"""Arms that the general solver leads quickly out to their reach: the tool comes late, on its path, to its end."""

import math
from dataclasses import replace
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from common.config.loading import load_config
from common.geometry import Array, transform
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import MODELS, SingularityConfig, SolverConfig
from remote_site.kinematics.differential import DifferentialInverse, Move
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.config import ControlConfig
from remote_site.motion.target_tracker import DifferentialTracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Code, Reason
from tests.remote_site.arms_followed import OFFSET_WRIST, SEVEN_AXES, Followed, HandMotion, smooth
from tests.remote_site.motion.test_stretched_elbow import LOOSE, WIDE, off_the_segment
from tests.remote_site.remote_loop import TICK_NS, arm, assert_within_limits

BEFORE_S, AFTER_S = 0.3, 5.0
MOST_M = 0.0125  # beside a line; without waiting, 27 to 118 mm
LEAST_S = 0.3  # for a line
SHOULDER_M = 0.33  # above the base, more or less
SAMPLE_TICKS = 8
REACHED_M, REACHED_RAD = 3e-4, 3e-3


def loose(config: RemoteConfig) -> RemoteConfig:
    """The same in an empty cell, and its target on a long leash."""
    robot = msgspec.structs.replace(config.robot, capsules=())
    collision = msgspec.structs.replace(config.safety.collision, fixtures=())
    safety = msgspec.structs.replace(WIDE, collision=collision)
    return RemoteConfig(robot=robot, safety=safety, control=ControlConfig(leash_m=1.0))


GENERAL = msgspec.structs.replace(LOOSE.robot, kinematics="general")
ARMS = {
    "offset wrist": loose(OFFSET_WRIST),
    "seven axes": loose(SEVEN_AXES),
    "a465": loose(RemoteConfig(robot=GENERAL)),
    "fr3": loose(load_config(RemoteConfig, MODELS / "fr3" / "fr3.toml")),
}


def reach_m(config: RemoteConfig, direction: Array) -> float:
    """How far the tool can go from the start in a direction (3,) with its orientation, in steps of 5 mm."""
    model, limits = arm(config)
    q, n = config.robot.start, len(limits.names)
    quick = replace(limits, velocity=np.full(n, 6.0), acceleration=np.full(n, 1e4), jerk=np.full(n, 1e6))
    solver = DifferentialInverse(model, quick, SolverConfig(), SingularityConfig(damp_condition=1e4), q)
    start, move, reached = model.forward(q).copy(), replace(Move.at_rest(q), off_m=math.inf, off_rad=math.inf), 0.0
    while True:
        pose = transform(start[:3, :3], start[:3, 3] + (reached + 0.005) * direction)
        for _ in range(80):
            move = solver.step(move, pose, np.zeros(6), 1.0, 0.02, None)
            if move.off_m < REACHED_M and move.off_rad < REACHED_RAD:
                break
        else:
            return reached
        reached += 0.005


def places_at_the_reach(config: RemoteConfig, seed: int) -> list[Array]:
    """The start, four places (3,) in m from it that are 0.5 to 30 mm short of the reach, and the start again."""
    rng = np.random.default_rng(seed)
    start = arm(config)[0].position(config.robot.start)
    out = start - [0.0, 0.0, SHOULDER_M]
    places = [np.zeros(3)]
    for short_m in np.exp(rng.uniform(math.log(0.0005), math.log(0.03), 4)):
        direction = out / np.linalg.norm(out) + rng.uniform(-0.35, 0.35, 3)
        direction /= np.linalg.norm(direction)
        places.append(max(reach_m(config, direction) - short_m, 0.02) * direction)
    return [*places, np.zeros(3)]


class Lines:
    """A hand from place to place, (3,) in m in the base's axes, on average as fast as that, and how it is followed."""

    def __init__(self, config: RemoteConfig, places: list[Array], hand_m_s: float) -> None:
        self.places = places
        self._times = BEFORE_S + np.cumsum(
            [0.0, *(max(math.dist(a, b) / hand_m_s, LEAST_S) for a, b in pairwise(places))]
        )
        base_R_operator = np.array(config.mapping.base_R_operator)
        followed = Followed(config, self._motion(base_R_operator), self._times[-1] + AFTER_S)
        self.loop, self.moved = followed.loop, followed.tools[:, :3, 3] - followed.start[:3, 3]

    def _motion(self, base_R_operator: Array) -> HandMotion:
        def motion(t: float) -> tuple[Array, Array]:
            leg = min(max(int(np.searchsorted(self._times, t)) - 1, 0), len(self.places) - 2)
            part = smooth((t - self._times[leg]) / (self._times[leg + 1] - self._times[leg]))
            return base_R_operator.T @ (self.places[leg] + part * (self.places[leg + 1] - self.places[leg])), np.zeros(
                3
            )

        return motion

    @property
    def beside_m(self) -> float:
        """How far the tool went from the nearest line, at most."""
        return float(np.min([off_the_segment(self.moved, a, b) for a, b in pairwise(self.places)], axis=0).max())

    @property
    def ended_off_m(self) -> float:
        """How far the tool is from the last place at the end."""
        return math.dist(self.moved[-1], self.places[-1])


def test_a_quick_line_to_the_reach_and_back_is_kept_to() -> None:
    config = ARMS["offset wrist"]
    lines = Lines(config, [np.zeros(3), places_at_the_reach(config, 0)[1], np.zeros(3)], 0.5)
    assert lines.beside_m < MOST_M
    assert lines.ended_off_m < 0.001
    assert lines.loop.refusals == 0
    assert_within_limits(lines.loop)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "hand_m_s"), [("seven axes", 0.5), ("a465", 0.5), ("fr3", 0.15)], ids=str)
def test_quick_lines_between_places_at_the_reach_are_kept_to(name: str, hand_m_s: float) -> None:
    lines = Lines(ARMS[name], places_at_the_reach(ARMS[name], 1), hand_m_s)
    assert lines.beside_m < MOST_M
    assert lines.ended_off_m < 0.002
    assert lines.loop.refusals == 0
    assert_within_limits(lines.loop)


class Led:
    """The general solver behind samples of a hand on one line, (3,) in the base's axes; its arm is where it is led."""

    def __init__(self, direction: tuple[float, float, float]) -> None:
        config = ARMS["seven axes"]
        self.model, limits = arm(config)
        self.tracker = DifferentialTracker(config.robot, config.control, self.model, limits)
        self.tracker.reset(0, config.robot.start)
        self.sent, self.ticks, self.direction = JointMotion.at_rest(config.robot.start), 0, np.array(direction)
        self.start = self.model.forward(self.sent.q).copy()
        self.answer: Reason | None = None
        self.go(50, 0.0)

    def go(self, ticks: int, *way_m: float, barred: bool = False) -> None:
        """The hand goes smoothly from the first of these to the last in so many ticks, or stays."""
        for k in range(ticks):
            self.ticks += 1
            now_ns = self.ticks * TICK_NS
            if self.ticks % SAMPLE_TICKS == 0:
                metres = way_m[0] + smooth(k / ticks) * (way_m[-1] - way_m[0])
                place = self.start[:3, 3] + metres * self.direction
                sample = ToolSample(now_ns, now_ns, transform(self.start[:3, :3], place), None, None)
                self.answer = self.tracker.aim(sample)
            self.sent = self.tracker.at(now_ns, self.sent, 1.0, barred=barred)

    @property
    def waits(self) -> bool:
        """Return whether the arm goes along its path."""
        return self.tracker._delayed.delay_s > 0.0

    @property
    def moved(self) -> tuple[float, float]:
        """How far the tool is from the start along the hand's line, and beside it, in m."""
        moved = self.model.position(self.sent.q) - self.start[:3, 3]
        along = float(moved @ self.direction)
        return along, float(np.linalg.norm(moved - along * self.direction))


@pytest.fixture
def late() -> Led:
    """An arm that has been left behind on its way."""
    led = Led((0.0, -1.0, 0.0))
    led.go(100, 0.0, 0.3)
    along, beside = led.moved
    assert along < 0.25
    assert beside < 0.005
    assert led.waits
    return led


def test_what_the_arm_is_late_it_makes_up_on_its_path(late: Led) -> None:
    beside = 0.0
    for _ in range(500):
        late.go(1, 0.3)
        beside = max(beside, late.moved[1])
    assert beside < 0.005
    assert late.moved[0] == pytest.approx(0.3, abs=5e-4)
    assert not late.waits
    assert late.answer is None


def test_a_stop_or_a_hold_ends_it_at_once_and_nothing_is_made_up(late: Led) -> None:
    q, (along, _) = late.sent.q, late.moved
    late.tracker.reset(late.ticks * TICK_NS, q)
    late.sent = JointMotion.at_rest(q)
    for _ in range(200):
        late.ticks += 1
        late.sent = late.tracker.at(late.ticks * TICK_NS, late.sent, 1.0)
        assert late.moved[0] == pytest.approx(along, abs=1e-4)


def test_an_arm_that_an_obstacle_bars_from_its_path_follows_the_hand_itself(late: Led) -> None:
    late.go(100, 0.3, barred=True)
    assert not late.waits
    late.go(400, 0.3, barred=True)
    assert late.moved[0] == pytest.approx(0.3, abs=5e-4)


def test_a_way_beyond_the_reach_is_kept_to_as_far_as_it_can_be_and_then_no_longer_waited_on() -> None:
    led, beside, waited = Led((0.0, 0.0, 1.0)), 0.0, 0
    for k in range(1000):
        led.go(1, 1.2 * smooth(k / 300))
        beside, waited = max(beside, led.moved[1] if led.waits else 0.0), waited + led.waits
    assert waited > 50
    assert beside < 0.01
    assert not led.waits
    assert led.answer is not None
    assert led.answer.code is Code.UNREACHED
