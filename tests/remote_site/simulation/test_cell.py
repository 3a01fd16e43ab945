"""The cell is the arm of the URDF, its gripper, block and views, where they are promised."""

import mujoco
import numpy as np
import pytest

from common.errors import ModelError
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import ArmConfig, BlockConfig, CellConfig
from remote_site.simulation.views import look_at
from tests.remote_site.simulation.cell_motion import arm_model

ROBOT = RobotConfig()


@pytest.fixture(scope="module")
def cell():
    return build_cell(CellConfig(), ROBOT)


def fingertips(data):
    left, right = (data.geom(name) for name in ("finger_left", "finger_right"))
    half_length = CellConfig().gripper.finger_length_m / 2
    return 0.5 * (left.xpos + right.xpos) + half_length * left.xmat.reshape(3, 3)[:, 2]


def test_the_tool_is_where_pinocchio_says(cell):
    model, data = arm_model(ROBOT), cell.start()
    rng = np.random.default_rng(4)
    for q in rng.uniform(model.lower, model.upper, (50, 6)):
        data.qpos[cell.arm] = q
        mujoco.mj_kinematics(cell.model, data)
        pose = model.forward(q)
        assert np.abs(fingertips(data) - pose[:3, 3]).max() < 1e-6
        assert np.abs(data.body("tool0").xmat.reshape(3, 3) - pose[:3, :3]).max() < 1e-6


def test_joints_bear_the_names_and_limits_of_the_urdf(cell):
    model = arm_model(ROBOT)
    assert cell.joints == model.joint_names
    for name, lower, upper, effort in zip(
        cell.joints, model.lower, model.upper, model.pin_model.effortLimit, strict=True
    ):
        assert cell.model.joint(name).range == pytest.approx([lower, upper])
        torque_range = cell.model.jnt_actfrcrange[cell.model.joint(name).id]
        assert torque_range == pytest.approx([-effort, effort])


def test_the_arm_starts_with_its_tool_level_and_forward(cell):
    data = cell.start()
    assert fingertips(data) == pytest.approx([0.4438, 0.0, 0.8685], abs=1e-4)
    assert data.body("tool0").xmat.reshape(3, 3)[:, 2] == pytest.approx([1, 0, 0], abs=1e-9)


def test_the_fingers_open_along_the_tool_y_axis(cell):
    data = cell.start()
    gap = data.geom("finger_left").xpos - data.geom("finger_right").xpos
    across = data.body("tool0").xmat.reshape(3, 3)[:, 1]
    assert data.ten_length[0] == pytest.approx(0.065)
    assert gap / np.linalg.norm(gap) == pytest.approx(across, abs=1e-9)


def test_the_target_lies_20_cm_to_the_right_of_the_block():
    block = CellConfig().block
    (x, y), (depth, thickness, _) = block.centre_xy_m, block.size_m
    corner = (x + depth / 2, y - thickness / 2 - 0.2)
    assert CellConfig().scene.target_corner_xy_m == pytest.approx(corner, abs=1e-9)


def test_the_four_views_of_the_thesis_are_there(cell):
    names = [cell.model.cam(i).name for i in range(cell.model.ncam)]
    assert names == ["front_high", "front_low", "side", "gripper"]
    assert cell.model.body(cell.model.cam("gripper").bodyid[0]).name == "tool0"


def test_a_wrong_tool_frame_is_named():
    with pytest.raises(ModelError, match=r"no link 'hand'.*robot\.tool_frame"):
        build_cell(CellConfig(), RobotConfig(tool_frame="hand"))


def test_a_missing_urdf_is_named(tmp_path):
    with pytest.raises(ModelError, match=r"none\.urdf"):
        build_cell(CellConfig(), RobotConfig(model=str(tmp_path / "none.urdf")))


def test_too_few_frictions_are_refused():
    with pytest.raises(ModelError, match="6 joints"):
        build_cell(CellConfig(arm=ArmConfig(coulomb_n_m=(1.0, 1.0))), ROBOT)


def test_a_camera_cannot_look_along_its_up():
    with pytest.raises(ModelError, match="cannot look"):
        look_at(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))


@pytest.mark.parametrize("yaw_deg", [0.0, -25.0])
def test_the_block_stands_turned_as_it_is_told_to(yaw_deg):
    block = BlockConfig(yaw_deg=yaw_deg)
    data = build_cell(CellConfig(block=block), ROBOT).start()
    rotation = data.body("block").xmat.reshape(3, 3)
    assert np.degrees(np.arctan2(rotation[1, 0], rotation[0, 0])) == pytest.approx(yaw_deg)
    assert rotation[2, 2] == pytest.approx(1.0)
    assert data.body("block").xpos[:2] == pytest.approx(block.centre_xy_m)
