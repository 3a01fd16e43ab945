"""A whole trial through pixels, and the site that it runs on."""

import gc
from types import FunctionType, ModuleType

import mujoco
import numpy as np
import pytest

from common.errors import CameraError
from lab.experiments.placing.trial import MOST_S, Conditions, _Trial, remote_config, run_trial
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import SteppedSite
from lab.visual_operator.sight.sight import Sight
from remote_site.config import RemoteConfig
from remote_site.simulation.process import SimulatedCell

BUILDING_SEED = 9


def test_the_stepped_site_is_the_same_each_time():
    one, other = (SteppedSite(RemoteConfig(), SteppedCell(RemoteConfig())) for _ in range(2))
    for _ in range(100):
        one.tick(())
        other.tick(())
    assert one.now_ns == other.now_ns
    assert one.robot.cell.data.qpos.tolist() == other.robot.cell.data.qpos.tolist()
    assert one.snapshot.state is other.snapshot.state


def test_the_block_starts_in_its_disc_turned_by_at_most_30_degrees():
    starts = [remote_config(np.random.default_rng(seed)).simulation.block for seed in range(200)]
    off = np.hypot(*(np.array([start.centre_xy_m for start in starts]) - (0.53, 0.04)).T)
    yaws = [abs(start.yaw_deg) for start in starts]
    assert 0.06 < off.max() <= 0.075
    assert 25 < max(yaws) <= 30


def reachable(root):
    """Every object that is reachable from one by attributes, items and closures, but not by a module or a class."""
    seen, waiting = {}, [root]
    while waiting:
        thing = waiting.pop()
        if id(thing) in seen or isinstance(thing, ModuleType | type):
            continue
        seen[id(thing)] = thing
        if isinstance(thing, FunctionType):
            waiting += [cell.cell_contents for cell in thing.__closure__ or ()]
        else:
            waiting += gc.get_referents(thing)
    return list(seen.values())


@pytest.mark.parametrize("altered", [(), ("exact_sight",)])
def test_the_operator_cannot_reach_the_simulation(altered):
    config = remote_config(np.random.default_rng(BUILDING_SEED))
    site = SteppedSite(config, SteppedCell(config))
    try:
        trial = _Trial(Conditions("silhouette", roll_fixed=True, seed=BUILDING_SEED, altered=altered), config, site)
    except CameraError as error:
        pytest.skip(str(error))
    within = {type(thing) for thing in reachable(trial.operator)}
    assert Sight in within or altered
    # An operator who is told the poses shows that the search would find a way there.
    assert bool(within & {SteppedSite, SimulatedCell, mujoco.MjData}) == bool(altered)


@pytest.mark.long
def test_the_visual_operator_places_the_block():
    try:
        result = run_trial(Conditions("silhouette", roll_fixed=True, seed=BUILDING_SEED))
    except CameraError as error:
        pytest.skip(str(error))
    assert result.end.placed
    assert abs(result.end.x_mm) < 8
    assert abs(result.end.y_mm) < 8
    assert abs(result.end.angle_deg) < 5
    assert result.drops == 0
    assert result.time_s < MOST_S
    assert result.grip_force_n > 1.0


@pytest.mark.long
def test_with_the_assist_the_block_is_placed_within_2_mm_and_1_degree():
    try:
        result = run_trial(Conditions("silhouette", roll_fixed=False, seed=BUILDING_SEED, assist=True))
    except CameraError as error:
        pytest.skip(str(error))
    assert result.end.placed
    assert abs(result.end.x_mm) < 2
    assert abs(result.end.y_mm) < 2
    assert abs(result.end.angle_deg) < 1
    assert result.drops == 0
