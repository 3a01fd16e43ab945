"""A dressed cell always looks the same, and moves as a bare one."""

import mujoco
import numpy as np
import pytest

from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig

STEPS = 300


def built(*, dressed):
    return build_cell(CellConfig(), RobotConfig(), dressed=dressed)


@pytest.fixture(scope="module")
def dressed():
    return built(dressed=True)


@pytest.fixture(scope="module")
def bare():
    return built(dressed=False)


def test_the_same_cell_looks_the_same_each_time_it_is_built(dressed):
    again = built(dressed=True)
    assert (again.model.tex_data == dressed.model.tex_data).all()
    for one, other in zip(again.surfaces, dressed.surfaces, strict=True):
        assert (one.picture == other.picture).all()


def test_what_can_be_touched_is_the_same(dressed, bare):
    shapes = []
    for cell in (dressed, bare):
        model = cell.model
        solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        shapes.append(np.column_stack([model.geom_pos[solid], model.geom_size[solid], model.geom_friction[solid]]))
    assert shapes[0].shape == shapes[1].shape
    assert (shapes[0] == shapes[1]).all()
    assert (dressed.model.body_mass == bare.model.body_mass).all()


def test_a_dressed_cell_moves_as_a_bare_one(dressed, bare):
    rests = []
    for cell in (dressed, bare):
        data = cell.start()
        data.qvel[cell.arm] = 0.3
        for _ in range(STEPS):
            mujoco.mj_step(cell.model, data)
        rests.append(data.qpos.copy())
    assert (rests[0] == rests[1]).all()
