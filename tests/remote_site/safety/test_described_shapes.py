"""What a cell says of its shapes: the capsules are where the guard measures, and everything fits into the message."""

import msgspec
import numpy as np
import pinocchio as pin
import pytest

from common.link.channels import DESCRIBE
from common.messages.codec import decode, encode
from common.messages.requests import Description
from common.messages.shapes import MOST_BOXES, MOST_CAPSULES
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import CapsuleConfig
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.request_server import describe
from remote_site.safety.collision import CollisionModel
from remote_site.safety.config import CollisionConfig, FixtureConfig

CONFIG = RemoteConfig()
MODEL, LIMITS = load_arm(CONFIG.robot)
SHAPES = describe(CONFIG, MODEL, LIMITS).shapes


def placed(q):
    """The ends (n, 2, 3) of the described capsules in the base's frame, by the model's own kinematics."""
    data = MODEL.pin_model.createData()
    pin.framesForwardKinematics(MODEL.pin_model, data, q)
    frames = [*data.oMi, data.oMf[MODEL.tcp_frame]]
    return np.array([[frames[c.link].act(np.array(end)) for end in (c.start, c.end)] for c in SHAPES.capsules])


def lowest_over_table(q):
    """How far the capsules that are above the table are from it, by the lower end of their axes, m."""
    ends, table = placed(q), next(box for box in SHAPES.fixtures if box.name == "table")
    radii = [capsule.radius for capsule in SHAPES.capsules]
    above = ((ends[:, :, :2] > table.lower[:2]) & (ends[:, :, :2] < table.upper[:2])).all(axis=(1, 2))
    return min((ends[above, :, 2].min(axis=1) - np.array(radii)[above]) - table.upper[2])


@pytest.mark.parametrize("bend", [-0.35, -0.2, 0.0])
def test_the_described_capsules_are_as_near_to_the_table_as_the_guard_measures(bend):
    q = np.array([0.0, -0.9, -0.6 + bend, 0.0, -0.4, 0.0])
    robot, collision = CONFIG.robot, CONFIG.safety.collision
    guard = CollisionModel.from_urdf(robot.urdf, MODEL, robot.capsules, collision)
    names = [set(guard.names(k)) for k in range(len(guard.distances(q)))]
    measured = min(d for d, pair in zip(guard.distances(q), names, strict=True) if "table" in pair and "tool0" in pair)
    assert lowest_over_table(q) == pytest.approx(measured, abs=1e-4)


def test_what_the_tool_carries_is_described_in_the_tools_frame():
    tip = [capsule for capsule in SHAPES.capsules if capsule.link == len(MODEL.joint_names) + 1]
    assert len(tip) == len(CONFIG.robot.capsules)
    assert min(capsule.end[2] + capsule.radius for capsule in tip) > -CONFIG.robot.tool_offset_m


def test_a_box_of_an_arm_is_described_by_a_capsule_along_its_longest_side(tmp_path):
    urdf = CONFIG.robot.urdf.read_text()
    boxed = urdf.replace('<cylinder radius="0.055" length="0.19"/>', '<box size="0.08 0.12 0.4"/>')
    (tmp_path / "boxed.urdf").write_text(boxed)
    robot = msgspec.structs.replace(CONFIG.robot, model=str(tmp_path / "boxed.urdf"))
    (arm,) = [c for c in describe(RemoteConfig(robot=robot), *load_arm(robot)).shapes.capsules if c.link == 2]
    assert arm.radius == pytest.approx(0.05)
    assert np.linalg.norm(np.subtract(arm.end, arm.start)) == pytest.approx(0.4 - 2 * 0.05)


def test_an_arm_whose_meshes_are_not_here_is_described_without_capsules(tmp_path):
    urdf = CONFIG.robot.urdf.read_text()
    meshed = urdf.replace('<cylinder radius="0.055" length="0.19"/>', '<mesh filename="elsewhere.stl"/>')
    (tmp_path / "meshed.urdf").write_text(meshed)
    robot = msgspec.structs.replace(CONFIG.robot, model=str(tmp_path / "meshed.urdf"))
    assert describe(RemoteConfig(robot=robot), *load_arm(robot)).shapes.capsules == ()


def test_of_more_shapes_than_the_message_takes_the_largest_are_described():
    pins = [
        CapsuleConfig(link="tool0", start_m=(0, 0, 0), end_m=(0, 0, 0.001 * k), radius_m=0.01)
        for k in range(2 * MOST_CAPSULES)
    ]
    boxes = [FixtureConfig(name=f"{k:064}", min_m=(2, 2, 2), max_m=(3, 3, 3 + 0.01 * k)) for k in range(2 * MOST_BOXES)]
    config = RemoteConfig(
        robot=msgspec.structs.replace(CONFIG.robot, capsules=tuple(pins)),
        safety=msgspec.structs.replace(CONFIG.safety, collision=CollisionConfig(fixtures=tuple(boxes))),
    )
    described = describe(config, MODEL, LIMITS)
    assert len(described.shapes.capsules) == MOST_CAPSULES
    assert {box.name for box in described.shapes.fixtures} == {box.name for box in boxes[MOST_BOXES:]}
    assert decode(encode(described), Description, DESCRIBE.max_bytes).shapes.gripper == SHAPES.gripper
