"""The model of the arm and its limits: what the URDF states, what makes it unusable, what configuration may change."""

import re
from pathlib import Path

import numpy as np
import pytest

from common.errors import ConfigError, ModelError
from common.geometry import rotation_from_vector, transform
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.inverse import Solution, SphericalWristInverse
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from tests.remote_site.remote_loop import arm

URDF = RobotConfig().urdf
ARMS = Path(__file__).parents[1] / "arms"
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])


@pytest.fixture
def variant(tmp_path):
    """The A465 with a text replaced, as a file."""

    def make(pattern: str, replacement: str) -> Path:
        text, count = re.subn(pattern, replacement, URDF.read_text(), flags=re.DOTALL)
        assert count
        path: Path = tmp_path / "arm.urdf"
        path.write_text(text)
        return path

    return make


def test_the_geometry_is_enough_to_find_the_tool():
    model, _ = arm()
    links, last_T_tool = model.geometry()
    q = START + 0.2
    base_T_tool = np.eye(4)
    for link, angle in zip(links, q, strict=True):
        assert not link.slides
        turn = transform(rotation_from_vector(np.array(link.axis) * angle), np.zeros(3))
        base_T_tool = base_T_tool @ link.parent_T_joint @ turn
    assert base_T_tool @ last_T_tool == pytest.approx(model.forward(q), abs=1e-9)


def load(path, tool_frame="tool0"):
    return ArmModel.from_urdf(path, tool_frame, np.eye(4))


def test_the_a465_stands_1041_mm_high_at_zero_and_its_tool_is_ahead_at_the_start():
    model, _ = arm()
    assert model.joint_names == tuple(f"joint_{k}" for k in range(1, 7))
    assert load(URDF).forward(np.zeros(6))[:3, 3] == pytest.approx([0.0, 0.0, 1.0414])
    assert model.forward(START)[:3, 3] == pytest.approx([0.4438, 0.0, 0.8685], abs=1e-4)
    assert model.forward(START)[:3, 2] == pytest.approx([1.0, 0.0, 0.0])


def test_the_flange_of_the_ready_posture():
    ready = np.radians([0.0, 0.0, -90.0, 0.0, 0.0, 0.0])
    assert load(URDF).forward(ready)[:3, 3] == pytest.approx([0.4064, 0.0, 0.635])


def test_the_jacobian_is_the_derivative_of_the_tool_centre_point():
    model, _ = arm()
    q = START + np.array([0.3, -0.2, 0.1, 0.5, 0.2, -0.4])
    jacobian = model.jacobian(q).copy()
    for k in range(6):
        step = 1e-6 * np.eye(6)[k]
        ahead, behind = model.forward(q + step).copy(), model.forward(q - step).copy()
        assert jacobian[:3, k] == pytest.approx((ahead - behind)[:3, 3] / 2e-6, abs=1e-6)
        spin = (ahead - behind)[:3, :3] / 2e-6 @ model.forward(q)[:3, :3].T
        assert jacobian[3:, k] == pytest.approx([spin[2, 1], spin[0, 2], spin[1, 0]], abs=1e-6)


@pytest.mark.parametrize("name", ["a465", "offset_wrist", "seven_axes", "sliding"])
def test_no_joint_moves_the_tool_further_than_its_lever(name, variant):
    slide = variant(r'(<joint name="joint_3" type=)"revolute"', r'\1"prismatic"') if name == "sliding" else None
    path = slide or (URDF if name == "a465" else ARMS / f"{name}.urdf")
    model, rng = load(path), np.random.default_rng(8)
    levers, reached = np.array(model.tcp_levers), np.zeros(len(model.joint_names))
    for _ in range(300):
        q = rng.uniform(model.lower, model.upper)
        speeds = np.linalg.norm(model.jacobian(q)[:3], axis=0)
        assert (speeds <= levers + 1e-9).all()
        reached = np.maximum(reached, speeds)
    assert (reached >= 0.25 * levers - 1e-9).all()  # nor are they much too long


@pytest.mark.parametrize("name", ["a465", "offset_wrist", "seven_axes", "sliding", "sliding base"])
def test_the_tool_is_never_out_of_its_reach(name, variant):
    sliding = {"sliding": "joint_3", "sliding base": "joint_1"}
    slide = name in sliding and variant(rf'(<joint name="{sliding[name]}" type=)"revolute"', r'\1"prismatic"')
    model, rng = load(slide or (URDF if name == "a465" else ARMS / f"{name}.urdf")), np.random.default_rng(8)
    low, high = model.reach
    tools = np.array([model.position(rng.uniform(model.lower, model.upper)) for _ in range(3000)])
    assert (tools >= low - 1e-9).all()
    assert (tools <= high + 1e-9).all()
    if not slide:  # nor is it much too large
        assert (np.ptp(tools, axis=0) >= 0.5 * (high - low)).all()


def test_the_reach_of_the_a465_is_its_length_about_the_shoulder():
    model = ArmModel.from_urdf(URDF, "tool0", RobotConfig().tool_T_tcp)
    assert model.reach[0] == pytest.approx([-0.8453, -0.8453, 0.3302 - 0.8453])
    assert model.reach[1] == pytest.approx([0.8453, 0.8453, 0.3302 + 0.8453])


def test_a_pose_is_not_changed_by_the_next_one():
    model, _ = arm()
    first = model.forward(START)
    kept = first.copy()
    model.forward(START + 0.3)
    assert np.array_equal(first, kept)


@pytest.mark.parametrize(
    ("pattern", "replacement", "words"),
    [
        (r"^.*$", "no robot", "cannot read"),
        (r'<joint name="joint_4"', '<joint name="joint_3"', "two joints are called joint_3; rename one"),
        (r'<link name="upper_arm"', '<link name="forearm"', "two links are called forearm; rename one"),
        (r'(<joint name="joint_4" type=)"revolute"', r'\1"continuous"', "joint_4"),
        (r'velocity="2.9845"( acceleration="24.958" jerk="1000" effort="6.89")', r'velocity="0"\1', "joint_4 needs"),
        (r'lower="-1.9199" upper="1.9199"', 'lower="1" upper="-1"', "joint joint_3 needs <limit"),
        (
            r'velocity="2.9845"( acceleration="24.958" jerk="1000" effort="6.89")',
            r"\1",
            "joint joint_4 needs <limit.*velocity",
        ),
        (r'(lower="-1.9199" upper="1.9199") velocity="[^"]*"', r'\1 velocity="fast"', "joint joint_3 needs <limit"),
        (r'(<joint name="joint_2".{0,200}jerk=)"1000"', r'\1"0"', "joint joint_2 needs <limit"),
        (r'(<joint name="joint_2".{0,200}jerk=)"1000"', r'\1"inf"', "joint joint_2 needs <limit"),
        (r'(<child link="forearm"/>.{0,60})<axis xyz="0 -1 0"', r'\1<axis xyz="0 0 0"', "joint joint_3 needs <axis"),
        (r'(<child link="forearm"/>.{0,60})<axis xyz="0 -1 0"', r'\1<axis xyz="0 -1"', "joint joint_3 needs <axis"),
        (r'type="revolute"', 'type="fixed"', "no moving joint"),
        (r'(<parent link=")forearm', r"\1upper_arm", "branches"),
    ],
)
def test_an_unusable_urdf_is_refused_with_the_cure(variant, pattern, replacement, words):
    with pytest.raises(ModelError, match=words):
        load(variant(pattern, replacement))


def test_a_missing_file_or_frame_is_refused(tmp_path):
    with pytest.raises(ModelError, match="cannot read"):
        load(tmp_path / "none.urdf")
    with pytest.raises(ModelError, match=r"robot\.tool_frame.*wrist_yaw"):
        load(URDF, "hook")


@pytest.mark.parametrize(
    ("pattern", "replacement", "words"),
    [
        (r'(<child link="upper_arm"/><origin xyz=")0 0', r"\g<1>0.1 0", "joint_2 lies beside"),
        (r'(<child link="wrist_roll"/><origin xyz=")0 0', r"\g<1>0 0.05", "joint_4 lies beside"),
        (r'(<child link="forearm"/>.{0,60}<axis xyz=)"0 -1 0"', r'\1"1 0 0"', "joint_3 does not turn"),
        (r'(<child link="forearm"/><origin xyz="0 0 )0.3048', r"\1-0.3048", "above each other"),
        (r'(<joint name="joint_6" type=)"revolute"', r'\1"fixed"', "5 joints"),
    ],
)
def test_an_arm_of_another_kind_has_no_closed_form(variant, pattern, replacement, words):
    model = load(variant(pattern, replacement))
    limits = JointLimits.from_model(model, RobotConfig(acceleration_rad_s2=(10.0,)))
    with pytest.raises(ModelError, match=words):
        SphericalWristInverse(model, limits)


def test_an_arm_beside_its_own_plane_has_a_closed_form(variant):
    """Shoulder and elbow are beside the axis of joint 1, as on many arms, and the wrist is on it again."""
    path = variant(
        r'(<child link="upper_arm"/><origin xyz=")0 0(.*<child link="wrist_roll"/><origin xyz=")0 0 ',
        r"\g<1>0 0.1\g<2>0 -0.1 ",
    )
    model = load(path)
    SphericalWristInverse(model, JointLimits.from_model(model, RobotConfig())).verify()


def test_the_closed_form_reads_lengths_and_signs_from_the_urdf(variant):
    path = variant(r'(<child link="forearm"/><origin xyz="0 0 )0.3048(.{0,40}axis xyz="0 )-1', r"\g<1>0.4\g<2>1")
    model = load(path)
    limits = JointLimits.from_model(model, RobotConfig())
    q = np.array([0.3, -0.4, 0.9, 0.2, -0.7, 0.5])
    solution = SphericalWristInverse(model, limits).nearest(model.forward(q), q)
    assert isinstance(solution, Solution)
    assert solution.q == pytest.approx(q, abs=1e-9)


def test_limits_are_the_urdfs_with_margin_and_the_configured_share():
    model = load(URDF)
    limits = JointLimits.from_model(model, RobotConfig(speed=0.5, position_margin_deg=2.0, jerk_rad_s3=77.0))
    assert limits.upper == pytest.approx(model.upper - np.radians(2.0))
    assert limits.lower == pytest.approx(model.lower + np.radians(2.0))
    assert limits.velocity == pytest.approx(0.5 * model.velocity)
    assert limits.acceleration.tolist() == [10.0, 10.0, 10.0, 20.0, 20.0, 20.0]
    assert limits.jerk.tolist() == [77.0] * 6


def test_accelerations_are_one_for_all_or_one_for_each():
    model = load(URDF)
    assert JointLimits.from_model(model, RobotConfig(acceleration_rad_s2=(3.0,))).acceleration.tolist() == [3.0] * 6
    with pytest.raises(ConfigError, match="acceleration_rad_s2 has 2 values"):
        JointLimits.from_model(model, RobotConfig(acceleration_rad_s2=(3.0, 4.0)))


def test_an_acceleration_above_the_robots_own_is_refused_by_joint_and_value():
    with pytest.raises(ConfigError, match=r"13 for joint_2 is above the robot's own 12\.566"):
        JointLimits.from_model(load(URDF), RobotConfig(acceleration_rad_s2=(10.0, 13.0, 10.0, 20.0, 20.0, 20.0)))


def test_a_jerk_above_the_arms_own_is_refused_by_joint_and_value(variant):
    own = variant(r'(<joint name="joint_2".{0,200}jerk=)"1000"', r'\1"400"')
    assert JointLimits.from_model(load(own), RobotConfig()).jerk.tolist() == [1000, 400, 1000, 1000, 1000, 1000]
    assert JointLimits.from_model(load(own), RobotConfig(jerk_rad_s3=400.0)).jerk.tolist() == [400.0] * 6
    with pytest.raises(
        ConfigError, match=r"jerk_rad_s3: 401 for joint_2 is above the arm's own 400; limits only tighten$"
    ):
        JointLimits.from_model(load(own), RobotConfig(jerk_rad_s3=401.0))


def test_an_arm_whose_file_states_no_jerk_has_100_and_nothing_widens_it(variant):
    model = load(variant(r' jerk="[^"]*"', ""))
    assert model.without_jerk == model.joint_names
    assert JointLimits.from_model(model, RobotConfig()).jerk.tolist() == [100.0] * 6
    with pytest.raises(ConfigError, match=r"101 for joint_1 is above 100.* states no jerk"):
        JointLimits.from_model(model, RobotConfig(jerk_rad_s3=101.0))


def test_configuration_can_tighten():
    limits = JointLimits.from_model(load(URDF), RobotConfig(position_deg={"joint_2": (-60.0, 45.0)}))
    assert np.degrees([limits.lower[1], limits.upper[1]]) == pytest.approx([-59.0, 44.0])


def test_an_attempt_to_widen_names_every_joint_and_value():
    config = RobotConfig(position_deg={"joint_2": (-95.0, 45.0), "joint_5": (0.0, 106.0), "elbow": (0.0, 1.0)})
    with pytest.raises(ConfigError) as error:
        JointLimits.from_model(load(URDF), config)
    for words in (r"joint_2.*-95\.0.*-90\.0", r"joint_5.*106\.0.*105\.0", "no joint 'elbow'.*joint_1"):
        assert re.search(words, str(error.value)), words


def test_limits_that_leave_no_room_are_refused():
    with pytest.raises(ConfigError, match=r"joint_1.*no room"):
        JointLimits.from_model(load(URDF), RobotConfig(position_deg={"joint_1": (0.0, 1.5)}))


@pytest.mark.parametrize("scale", [1.01, 0.0, -1.0, np.nan])
def test_the_speed_scale_cannot_widen(scale):
    _, limits = arm()
    with pytest.raises(ValueError, match="widen"):
        limits.scaled_speed(scale)
