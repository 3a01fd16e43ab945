"""A block placed by hand once, the task extracted, and run again with block and target moved together."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.messages.robot import GripperCommand, SessionState
from farhand.replay.recorded_tool_path import path_of
from farhand.teach.extraction import task_of
from farhand.teach.planning import planned_path
from farhand.teach.task_file import TaskFile, TaskOrigin, TaughtFrame
from lab.experiments.placing.judge import Judge, Placed
from lab.experiments.placing.trial import MOST_S, Conditions, _Trial, remote_config
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import SteppedSite
from local_site.programmed.path_progress import PathProgress
from remote_site.config import RemoteConfig
from tests.led_cell import LedCell, robot_state

SEED = 71
MOVED_M = 0.01
RUNS = 2  # 20 were measured
STATES_EVERY = 3

pytestmark = pytest.mark.long


def by_hand(config: RemoteConfig) -> TaskFile:
    """The task of the scripted operator's placing, with tracker and sight as they truly are."""
    site = SteppedSite(config, SteppedCell(config))
    judge = Judge(config, site.robot.cell)
    trial = _Trial(Conditions("silhouette", False, SEED, ("exact_tracker", "exact_sight")), config, site)
    states = []
    while not trial.operator.done and trial.time_s < MOST_S:
        for _ in range(STATES_EVERY):
            trial.step()
        if site.snapshot.state is SessionState.ENGAGED:
            states.append(robot_state(site))
    assert judge.placed().placed
    origin = TaskOrigin(name="place", robot="a465", gripper_at_start="open", tolerance_mm=2.0, tolerance_deg=2.0)
    return task_of(path_of(states), origin, None)


def moved(config: RemoteConfig, way_m: tuple[float, float]) -> RemoteConfig:
    """The cell with block and target moved together."""
    simulation = config.simulation
    x, y = np.add(simulation.block.centre_xy_m, way_m).tolist()
    to_x, to_y = np.add(simulation.scene.target_corner_xy_m, way_m).tolist()
    block = replace(simulation.block, centre_xy_m=(x, y))
    scene = replace(simulation.scene, target_corner_xy_m=(to_x, to_y))
    return replace(config, simulation=replace(simulation, block=block, scene=scene))


def run_again(task: TaskFile, config: RemoteConfig, way_m: tuple[float, float]) -> Placed:
    """Where the block is left by a run in the moved cell, for which only the frame was taught anew."""
    x, y, z = task.frame.xyz_mm
    frame = TaughtFrame(xyz_mm=(x + 1e3 * way_m[0], y + 1e3 * way_m[1], z))
    progress = PathProgress(planned_path(task, frame.base_T_frame), 1.0, stepwise=False)
    config = moved(config, way_m)
    cell = LedCell(progress, GripperCommand.OPEN, config=config)
    judge = Judge(config, cell.site.robot.cell)
    cell.pass_s(1.0)
    cell.key_held = True
    cell.until("done", 240.0)
    cell.pass_s(1.0)
    return judge.placed()


def test_what_was_done_by_hand_once_is_done_again_wherever_the_fixture_stands() -> None:
    rng = np.random.default_rng(SEED)
    config = remote_config(rng)
    task = by_hand(config)
    for _ in range(RUNS):
        angle, radius = rng.uniform(0, 2 * np.pi), MOVED_M * np.sqrt(rng.uniform())
        end = run_again(task, config, (radius * np.cos(angle), radius * np.sin(angle)))
        assert end.placed
        assert max(abs(end.x_mm), abs(end.y_mm)) < 5.0
