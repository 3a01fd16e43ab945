"""Other kinds of arms through the whole pipeline: within 2 mm, elbow steered, at rest before targets out of reach."""

import msgspec
import numpy as np
import pytest

from common.errors import ModelError
from common.geometry import vector_from_rotation
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import BranchConfig, RobotConfig, SolverConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.config import ControlConfig
from remote_site.motion.target_tracker import ClosedFormTracker, DifferentialTracker, choose_target_tracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Code
from remote_site.teleop.config import prediction
from tests.remote_site.arms_followed import (
    A465,
    OFFSET_WRIST,
    SEVEN_AXES,
    Followed,
    figure_of_eight,
    pick_and_place,
    smooth,
)
from tests.remote_site.remote_loop import arm, assert_within_limits


def still(_t):
    return np.zeros(3), np.zeros(3)


@pytest.mark.parametrize("config", [A465, OFFSET_WRIST, SEVEN_AXES], ids=["a465", "offset wrist", "seven axes"])
@pytest.mark.parametrize(("motion", "seconds"), [(pick_and_place, 6.0), (figure_of_eight, 6.0)])
def test_the_tool_follows_the_hand_within_2_mm(config, motion, seconds):
    followed = Followed(config, motion, seconds)
    lag_ms, worst_mm, _ = followed.off_mm()
    assert lag_ms <= 8.0
    assert worst_mm < 2.0
    assert followed.loop.refusals == 0
    tool_R_now = followed.tools[-1, :3, :3] @ followed.start[:3, :3].T
    assert vector_from_rotation(tool_R_now) == pytest.approx(followed.turns[-1], abs=0.02)
    assert_within_limits(followed.loop)


@pytest.mark.slow
@pytest.mark.parametrize("config", [A465, OFFSET_WRIST, SEVEN_AXES], ids=["a465", "offset wrist", "seven axes"])
def test_with_the_default_gains_the_tool_follows_within_1_mm_on_the_average(config):
    default = msgspec.structs.replace(config, control=ControlConfig(solver=config.control.solver))
    followed = Followed(default, pick_and_place, 6.0)
    off_mm = 1e3 * np.linalg.norm(followed.tools[:, :3, 3] - followed.start[:3, 3] - followed.hands, axis=1)
    assert off_mm.mean() < 1.0
    assert off_mm.max() < 2.6
    assert_within_limits(followed.loop)


def swinging_elbow(t):
    """The operator's elbow 0.2 m behind the wrist, swinging by 0.6 rad about the arm."""
    a = 0.6 * np.sin(2 * np.pi / 6 * t) * smooth(t)
    return np.array([0.15 * np.sin(a), 0.2, -0.15 * np.cos(a)])


def elbow_turn(loop, q, axis_and_zero):
    """The turn of the robot's elbow about the line from shoulder to wrist, rad."""
    axis, zero = axis_and_zero
    across = places(loop, q)[1] - places(loop, q)[0]
    across = across - axis * (axis @ across)
    return np.arctan2(np.cross(zero, across) @ axis, zero @ across)


def places(loop, q):
    """Shoulder, elbow and wrist in the base frame."""
    import pinocchio as pin

    data = loop.model.pin_model.createData()
    pin.forwardKinematics(loop.model.pin_model, data, q)
    return [np.array(data.oMi[k].translation) for k in (2, 4, 6)]


def test_the_elbow_of_seven_axes_turns_as_the_operators_while_the_tool_stays():
    followed = Followed(SEVEN_AXES, still, 6.0, swinging_elbow)
    loop = followed.loop
    assert followed.off_mm()[1] < 2.0
    shoulder, elbow, wrist = places(loop, loop.config.robot.start)
    axis = (wrist - shoulder) / np.linalg.norm(wrist - shoulder)
    zero = (elbow - shoulder) - axis * (axis @ (elbow - shoulder))
    turns = [elbow_turn(loop, motion.q, (axis, zero)) for motion in loop.log[-1500:]]
    theirs = [np.arctan2(*swinging_elbow(k * 0.004)[[0, 2]] * [1, -1]) for k in range(1500)]
    # base_R_operator takes the operator's x to the base's y: seen along the arm, both turn in the same direction
    delay = 40
    assert np.abs(np.array(turns[delay:]) - np.array(theirs[:-delay])).max() < 0.15
    assert np.ptp(turns) > 1.0
    assert_within_limits(loop)


def test_an_elbow_that_is_not_seen_leaves_the_free_motion_to_the_posture():
    followed = Followed(SEVEN_AXES, still, 1.0)
    assert np.abs(followed.loop.sent.q - followed.loop.config.robot.start).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("config", [OFFSET_WRIST, SEVEN_AXES], ids=["offset wrist", "seven axes"])
def test_a_target_3_m_away_is_leashed_without_thrash_and_the_way_back_is_open(config):
    def out_and_back(t):
        out = 3.0 * (smooth(t / 3.0) - smooth((t - 6.5) / 3.0))
        return np.array([0.0, -out, 0.0]), np.zeros(3)

    followed = Followed(config, out_and_back, 11.0)
    loop = followed.loop
    _, dq, ddq = loop.arrays()
    away = slice(-1250, -1150)
    assert np.abs(dq[away]).max() < 0.05
    assert np.abs(ddq[away]).max() < 1.0
    assert loop.saturated > 500
    assert np.linalg.norm(followed.tools[-1, :3, 3] - followed.start[:3, 3]) < 0.005
    assert_within_limits(loop)


def test_a_wrist_swept_through_its_singularity_keeps_every_limit_and_backs_out():
    """The general solver on the A465: the hand tips by 90 deg, which takes joint 5 from -45 deg through 0."""
    start = np.array([0.0, 10.0, -70.0, 0.0, -45.0, 0.0])
    config = RemoteConfig(robot=RobotConfig(kinematics="general", start_deg=tuple(start)))

    def tip(t):
        return np.zeros(3), np.array([-np.radians(70.0) * (smooth(t / 3.0) - smooth((t - 4.0) / 3.0)), 0.0, 0.0])

    followed = Followed(config, tip, 8.5)
    q, dq, _ = followed.loop.arrays()
    assert q[:, 4].max() > 0.1
    assert (np.abs(dq) <= followed.loop.limits.velocity * 1.00001).all()
    assert np.abs(followed.loop.sent.q - np.radians(start)).max() < 0.05
    assert_within_limits(followed.loop)


def chosen(config):
    return choose_target_tracker(config.robot, prediction(config), *arm(config))


def test_the_closed_form_is_taken_where_it_fits_and_the_solver_elsewhere():
    assert isinstance(chosen(RemoteConfig()), ClosedFormTracker)
    assert isinstance(chosen(OFFSET_WRIST), DifferentialTracker)
    assert isinstance(chosen(SEVEN_AXES), DifferentialTracker)
    assert isinstance(chosen(RemoteConfig(robot=RobotConfig(kinematics="general"))), DifferentialTracker)


def test_a_closed_form_asked_of_an_arm_that_it_does_not_fit_is_refused():
    robot = OFFSET_WRIST.robot
    config = RemoteConfig(
        robot=RobotConfig(
            model=robot.model, start_deg=robot.start_deg, capsules=(), acceleration_rad_s2=(10.0,), kinematics="closed"
        )
    )
    with pytest.raises(ModelError, match=r'robot.kinematics = "closed".*wrist_1 does not turn.*"general"'):
        chosen(config)


def test_a_chosen_stance_must_be_that_of_the_start_and_is_kept():
    with pytest.raises(ModelError, match=r"robot\.stance\.elbow"):
        chosen(RemoteConfig(robot=RobotConfig(stance=BranchConfig(elbow="backward"))))
    config = RemoteConfig(robot=RobotConfig(stance=BranchConfig(elbow="forward", wrist="forward")))
    tracker, (model, _) = chosen(config), arm(config)
    q = config.robot.start.copy()
    q[4] = 0.2  # bent backward
    tracker.reset(0, config.robot.start)
    assert tracker.aim(ToolSample(10**8, 10**8, model.forward(q), None, None)).code is Code.STANCE


def test_swivel_joints_that_the_arm_has_not_are_refused():
    robot = SEVEN_AXES.robot
    control = ControlConfig(solver=SolverConfig(swivel_joints=("a2", "elbow", "a6")))
    with pytest.raises(Exception, match=r"no joint elbow.*a1, a2"):
        chosen(RemoteConfig(robot=robot, control=control))


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_target_that_is_not_finite_moves_nothing(value):
    tracker, (model, _) = chosen(SEVEN_AXES), arm(SEVEN_AXES)
    start = SEVEN_AXES.robot.start
    tracker.reset(0, start)
    pose = model.forward(start)
    pose[0, 3] = value
    assert tracker.aim(ToolSample(10**8, 10**8, pose, None, None)).code is Code.NOT_A_POSE
    assert (
        tracker.aim(ToolSample(10**8, 10**8, model.forward(start), np.array([value, 0.0, 0.0]), None)).code
        is Code.NOT_A_POSE
    )
    target = tracker.at(2 * 10**8, JointMotion.at_rest(start), 1.0)
    assert np.abs(target.q - start).max() < 1e-9
    assert np.abs(target.dq).max() < 1e-6


def test_a_joint_outside_its_limits_is_brought_back_and_none_goes_out():
    model, limits = arm(SEVEN_AXES)
    start = SEVEN_AXES.robot.start.copy()
    start[5] = limits.upper[5] + 0.2
    tracker = chosen(SEVEN_AXES)
    tracker.reset(0, start)
    tracker.aim(ToolSample(4 * 10**6, 4 * 10**6, model.forward(start), None, None))
    q = start
    for k in range(400):
        target = tracker.at((k + 2) * 4 * 10**6, JointMotion.at_rest(q), 1.0)
        q = target.q
        assert np.isfinite(q).all()
        assert (np.abs(target.dq) <= limits.velocity).all()
        assert q[5] <= start[5] + 1e-12
    assert q[5] <= limits.upper[5] + 0.01
