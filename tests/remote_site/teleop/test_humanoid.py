"""The humanoid's right arm: where its palm is, what its cell shows, and that it does what the operator's arm does."""

import numpy as np
import pinocchio as pin
import pytest

from common.config.loading import load_config
from common.messages.hand import TrackingStatus
from farhand.loopback.scenario import (
    ARM_FILES,
    HUMANOID,
    MONOCULAR,
    arm_settings,
)
from lab.experiments.following import FollowingArm
from local_site.simulation.hazel import Swing, true_points
from local_site.tracking.tracker import ArmEstimate
from remote_site.config import RemoteConfig
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.checks import check_robot
from remote_site.simulation.cell import build_cell

INCH = 0.0254
CONFIG = load_config(RemoteConfig, ARM_FILES[HUMANOID], arm_settings(MONOCULAR))
ROBOT = CONFIG.robot
FPS = 30.0


@pytest.fixture(scope="module")
def model():
    return ArmModel.from_urdf(ROBOT.urdf, ROBOT.tool_frame, ROBOT.tool_T_tcp)


def placed(model, q):
    data = model.pin_model.createData()
    pin.framesForwardKinematics(model.pin_model, data, q)
    return lambda name: data.oMf[model.pin_model.getFrameId(name)]


def test_it_is_a_right_arm_of_seven_axes_that_can_start(model):
    check_robot(CONFIG)
    assert len(model.joint_names) == 7
    hanging = placed(model, np.zeros(7))
    shoulder, elbow, wrist = (hanging(name).translation for name in ("shoulder", "forearm", "wrist"))
    assert shoulder[1] < -0.15  # y is to the left
    np.testing.assert_allclose(hanging("upper_arm").translation, shoulder)
    np.testing.assert_allclose(wrist - shoulder, [0.0, 0.0, -0.61], atol=1e-9)
    np.testing.assert_allclose(elbow - shoulder, [0.0, 0.0, -0.32], atol=1e-9)
    np.testing.assert_allclose(hanging("hand").translation, wrist)


def test_the_palm_is_on_the_back_of_the_hand_forward_of_the_wrist(model):
    """Hanging, the palm of the hand looks to the body, so that its back is to the right."""
    for q in (np.zeros(7), ROBOT.start, np.radians([40.0, 20.0, 30.0, 70.0, -40.0, 25.0, 30.0])):
        frames = placed(model, q)
        hand, palm = frames("hand"), frames("palm")
        offset = hand.rotation.T @ (palm.translation - hand.translation)
        np.testing.assert_allclose(offset, [0.0, -0.5 * INCH, -1.5 * INCH], atol=1e-9)
        np.testing.assert_allclose(palm.rotation[:, 2], -hand.rotation[:, 2], atol=1e-9)
        np.testing.assert_allclose(model.forward(q)[:3, 3], palm.translation)


def test_the_cell_has_a_coronal_and_a_sagittal_view_of_the_upright_torso():
    cell = build_cell(CONFIG.simulation, ROBOT)
    data = cell.start()
    views = {name: data.cam(name) for name in ("coronal", "sagittal", "head", "hand")}
    looks = {name: -view.xmat.reshape(3, 3)[:, 2] for name, view in views.items()}
    assert looks["coronal"] @ [-1.0, 0.0, 0.0] > 0.99
    assert looks["sagittal"] @ [0.0, 1.0, 0.0] > 0.99
    assert views["sagittal"].xpos[1] < -1.0  # the side of the right arm
    upright = [view.xmat.reshape(3, 3)[2, 1] for name, view in views.items() if name in ("coronal", "sagittal")]
    assert min(upright) > 0.99
    palm, gripper = data.body("palm"), data.body("gripper_body")
    assert palm.xmat.reshape(3, 3)[:, 2] @ (gripper.xpos - palm.xpos) > 0.03
    assert data.ncon <= 4  # the block on the table, and nothing else


def estimate_of(points, t_ns):
    return ArmEstimate(t_ns, TrackingStatus.TRACKED, "", **points)


@pytest.fixture(scope="module")
def followed():
    """The arm after two and a half seconds of the swing, with the elbow that is tracked."""
    arm, swing = FollowingArm(CONFIG), Swing()
    palms, times_ns = [], []
    for k in range(110):
        points, t_ns = true_points(swing.arm(max(k - 35, 0))), round((k + 1) * 1e9 / FPS)
        arm.run_until(t_ns + 10_000_000)
        arm.send(estimate_of(points, t_ns))
        palms.append(points["palm"])
        times_ns.append(t_ns)
    return arm, np.array(times_ns), np.array(palms)


def test_the_palm_does_what_the_operators_does(followed):
    arm, times_ns, palms = followed
    assert arm.path.hindered == {}
    tool = np.array([pose[:3, 3] for pose in arm.path.poses])
    moved = (palms - palms[0]) @ np.array(CONFIG.mapping.base_R_operator).T
    wanted = np.column_stack([np.interp(arm.path.times_ns, times_ns, moved[:, k]) for k in range(3)])
    off_mm = 1e3 * np.linalg.norm(tool - tool[0] - wanted, axis=1)
    assert np.ptp(tool, axis=0).max() > 0.25
    assert off_mm.mean() < 8.0
    turned = [pin.log3(pose[:3, :3] @ arm.path.poses[0][:3, :3].T) for pose in arm.path.poses]
    assert np.abs(turned).max() < 0.05


def test_a_sample_without_a_palm_is_refused(followed):
    arm, times_ns, _ = followed
    before = arm.path.engaged_ns
    t_ns = int(times_ns[-1]) + round(1e9 / FPS)
    points = dict(true_points(Swing().arm(0)))
    del points["palm"]
    arm.run_until(t_ns + 10_000_000)
    arm.send(estimate_of(points, t_ns))
    arm.run_until(t_ns + 20_000_000)
    assert arm.path.engaged_ns == before
    assert arm.path.hindered["no_wrist"] > 0


def test_the_elbow_turns_about_the_arms_own_line_as_the_operators_does(model):
    start = placed(model, ROBOT.start)
    shoulder, elbow, wrist = (np.array(start(name).translation) for name in ("shoulder", "forearm", "wrist"))
    line = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    operator_R_base = np.array(CONFIG.mapping.base_R_operator).T
    hand = np.array([0.2, 0.0, 1.3])
    arm, angles = FollowingArm(CONFIG), []
    for k in range(110):
        angles.append(0.4 * np.sin(np.pi * max(k - 35, 0) / 75) ** 2)
        turned = pin.exp3(angles[-1] * line) @ (elbow - wrist)
        t_ns = round((k + 1) * 1e9 / FPS)
        arm.run_until(t_ns + 10_000_000)
        operators = {"elbow": hand + operator_R_base @ turned, "wrist": hand, "palm": hand}
        arm.send(ArmEstimate(t_ns, TrackingStatus.TRACKED, "", **operators))
        if k == 75:
            now = placed(model, arm.loop.sent.q)
    across = [v - line * (line @ v) for v in (elbow - shoulder, now("forearm").translation - shoulder)]
    followed = np.arctan2(np.cross(*across) @ line, across[0] @ across[1])
    assert followed == pytest.approx(angles[70], abs=0.06)
    assert angles[70] > 0.3
    np.testing.assert_allclose(arm.path.poses[-1], arm.path.poses[0], atol=2e-3)
