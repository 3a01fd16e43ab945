"""Robots that take their time follow an exact hand on stepped time: their lag, and the gripper at each gesture."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.hand import TrackingStatus
from lab.experiments.follow import OBJECT_M, cell_with_block
from lab.experiments.following import Film, ToolPath, follow_by_pipeline, follow_on_robot
from lab.stage.stepped.robots import SteppedCell, SteppedController, SteppedRobot
from local_site.samples.smoothing import SmoothingConfig
from local_site.simulation.config import MotionConfig, MotionName, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.emulator import Emulated

FPS, STILL_S, LATENCY_MS = 30.0, 2.0, 10.0
FRAMES: list[int] = []


def exact_film(motion: MotionName, seconds: float) -> Film:
    """What a tracker without errors measures."""
    operator = SimulatedOperator(SimulationConfig(motion=MotionConfig(name=motion, still_s=STILL_S)))

    def exact(t_ns: int) -> ArmEstimate:
        true = operator.truth(t_ns / NS_PER_S)
        points = {name: getattr(true, name) for name in ("elbow", "wrist", "index", "thumb")}
        return ArmEstimate(t_ns, TrackingStatus.TRACKED, "", **points, hand_open=true.hand_open)

    return Film(operator, FPS, tuple(exact(round(k * NS_PER_S / FPS)) for k in range(round(seconds * FPS))))


def emulated(remote: RemoteConfig) -> SteppedController:
    return SteppedController(remote, Emulated(object_m=OBJECT_M))


def followed(film: Film, robot: SteppedRobot) -> ToolPath:
    return follow_on_robot(film, SmoothingConfig(), cell_with_block(), LATENCY_MS, robot, lambda: FRAMES.append(1))


def at(path: ToolPath, values: list[float], t_s: float) -> float:
    return float(np.interp(t_s * NS_PER_S, path.times_ns, values))


def places(path: ToolPath, times_ns: Array) -> Array:
    """Where the tool was at times (N,): (N, 3) in m."""
    tool = np.array(path.poses)[:, :3, 3]
    return np.column_stack([np.interp(times_ns, path.times_ns, tool[:, k]) for k in range(3)])


@pytest.mark.parametrize(("robot", "open_mm"), [(emulated, 50.8), (SteppedCell, 65.0)])
def test_the_gripper_closes_at_the_first_gesture_and_opens_at_the_second(robot, open_mm):
    FRAMES.clear()
    path = followed(exact_film("toggles", 6.0), robot(cell_with_block()))
    openings = [at(path, path.openings_m, t_s) for t_s in (STILL_S + 0.5, STILL_S + 2.4, STILL_S + 3.9)]
    closed_m = OBJECT_M if robot is emulated else 0.0
    np.testing.assert_allclose(openings, [open_mm / 1e3, closed_m, open_mm / 1e3], atol=5e-4)
    assert path.hindered == {}
    assert len(FRAMES) == 180


@pytest.mark.parametrize(("robot", "least_ms", "most_ms"), [(emulated, 180, 280), (SteppedCell, 0, 40)])
def test_a_robot_lags_behind_one_that_follows_exactly(robot, least_ms, most_ms):
    film, remote = exact_film("reach_and_adjust", 8.0), cell_with_block()
    own = followed(film, robot(remote))
    exact = follow_by_pipeline(film, SmoothingConfig(), remote, LATENCY_MS)
    assert own.hindered == exact.hindered == {}
    times_ns = np.arange(3.0, 7.5, 0.02) * NS_PER_S

    def off(lag_ms: int) -> float:
        apart = places(own, times_ns) - places(exact, times_ns - lag_ms * NS_PER_MS)
        return float(np.linalg.norm(apart, axis=1).mean())

    lag_ms = min(range(0, 401, 4), key=off)
    assert least_ms <= lag_ms <= most_ms
    assert off(lag_ms) < 0.001


def test_the_arm_in_physics_carries_the_block_and_lets_go_of_it():
    robot = SteppedCell(cell_with_block())
    stood = robot.block_xy_m
    path = followed(exact_film("reach_and_adjust", STILL_S + 34.0), robot)
    assert path.hindered == {}
    assert at(path, path.openings_m, STILL_S + 28.0) == pytest.approx(0.05, abs=0.001)
    assert path.openings_m[-1] == pytest.approx(0.065, abs=0.001)
    begin, end = places(path, np.array([STILL_S + 17.5, STILL_S + 32.0]) * NS_PER_S)
    carried = robot.block_xy_m - stood
    np.testing.assert_allclose(carried, (end - begin)[:2], atol=0.025)  # pushed a little before it is held
    assert np.linalg.norm(carried) > 0.13


def test_the_same_hand_is_followed_the_same_way_each_time():
    film = exact_film("reach_and_adjust", 4.0)
    one, other = (followed(film, emulated(cell_with_block())) for _ in range(2))
    assert one.times_ns == other.times_ns
    np.testing.assert_array_equal(one.poses, other.poses)
