"""A live trial has the cell, the tracker and the operator's arm of the stepped trial with the same seed."""

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from common.config.loading import load_config
from lab.experiments.placing.live.plan import OPERATOR_NAME, live_plan
from lab.experiments.placing.trial import WRIST_M, Conditions, remote_config
from local_site.config import LocalConfig
from local_site.console.config import ConsoleConfig
from local_site.simulation.config import MotionConfig, SimulationConfig
from remote_site.config import RemoteConfig

PORTS = (7001, 7002, 7003, 7004)


def plan(seed=9, roll_fixed=True, method="silhouette"):
    return live_plan(Conditions(method, roll_fixed, seed), PORTS, Path("folder"))


@pytest.mark.parametrize("seed", [1, 9, 77])
def test_the_cell_is_that_of_the_stepped_trial(seed):
    stepped, live = remote_config(np.random.default_rng(seed)), load_config(RemoteConfig, None, plan(seed).remote)
    assert replace(live, cell=stepped.cell, links=stepped.links) == stepped


@pytest.mark.parametrize(("method", "markers"), [("silhouette", False), ("markers", True)])
def test_the_arm_is_that_of_the_stepped_trial_but_for_who_leads_it(method, markers):
    live = load_config(LocalConfig, None, plan(method=method).local)
    motion = MotionConfig(begins="at_once", still_s=0.0, wrist=WRIST_M)
    assert live.simulation == SimulationConfig(motion=motion, seed=9, markers=markers)
    assert live.tracking.method == method


def test_all_meet_at_the_same_endpoints():
    made = plan()
    remote, local = load_config(RemoteConfig, None, made.remote), load_config(LocalConfig, None, made.local)
    console = load_config(ConsoleConfig, None, made.console)
    assert remote.cell == local.cell == console.cell
    assert remote.links.control_endpoint == local.links.remote == console.links.control == made.control
    assert local.links.listen == console.links.local == made.listen
    assert console.serve.port == made.operator.port
    assert local.authority.name == console.name == OPERATOR_NAME


def test_the_operator_locks_the_roll_where_it_is_fixed():
    assert plan(roll_fixed=True).operator.roll_fixed
    assert not plan(roll_fixed=False).operator.roll_fixed
