"""What a remote site refuses before it starts, and what an unordered end leaves behind."""

import re
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from structlog.testing import capture_logs

from common.config.loading import load_config
from common.errors import ConfigError
from remote_site.config import RemoteConfig
from remote_site.drivers.config import DriverConfig
from remote_site.kinematics.config import CapsuleConfig, RobotConfig
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.checks import check_robot, find_mistakes, say_what_is_not_guarded
from remote_site.runtime.crash_marker import CrashMarker
from remote_site.runtime.driver_process import setup_of
from remote_site.safety.config import CollisionConfig, SafetyConfig
from remote_site.session.config import ACCEPTANCE, EngagementMode
from remote_site.simulation.config import ArmConfig, CellConfig, ServoConfig
from remote_site.teleop.config import MappingConfig
from remote_site.video.config import CameraConfig, VideoConfig
from tests.present import present
from tests.remote_site.arms_followed import ARMS

ROOT = Path(__file__).parents[3]
SEVEN: dict[str, Any] = {
    "model": str(ARMS / "seven_axes.urdf"),
    "acceleration_rad_s2": (10.0,),
    "start_deg": (0, 30, 0, 60, 0, 40, 0),
}
REAL = VideoConfig(cameras=(CameraConfig(name="front", source="/dev/video0"),))
HOOK = CapsuleConfig(link="hook", start_m=(0.0, 0.0, 0.0), end_m=(0.0, 0.0, 0.1), radius_m=0.02)
RUNNING_SITE = """
import time
from remote_site.runtime.crash_marker import CrashMarker
CrashMarker("cell").set()
print("runs", flush=True)
time.sleep(60)
"""


def test_the_defaults_are_right():
    check_robot(RemoteConfig())


@pytest.mark.parametrize(
    ("robot", "words"),
    [
        (RobotConfig(start_deg=(0, 0, 500, 0, 0, 0)), "joint_3 at 500 deg is outside -109.0 to 109.0"),
        (RobotConfig(start_deg=(0, 0, 0)), "3 angles for 6 joints"),
        (RobotConfig(model="ur5"), "neither a built-in model \\(a465, fr3, humanoid\\) nor the file"),
        (RobotConfig(position_deg={"joint_1": (-400, 400)}), "limits only tighten"),
        (RobotConfig(tool_frame="hook"), "no frame 'hook'; set robot.tool_frame"),
        (RobotConfig(capsules=(HOOK,)), "robot.capsules: there is no link 'hook'"),
        (RobotConfig(jerk_rad_s3=5000.0), "5000 for joint_1 is above the arm's own 1000"),
        (RobotConfig(jerk_rad_s3=1.0), "joint_1 may take 7090 ms to stop"),
        (RobotConfig(jerk_rad_s3=0.01), "joint_1 may take 70899 ms to stop"),
        (RobotConfig(acceleration_rad_s2=(0.01,)), "joint_1 may take 314161 ms to stop"),
    ],
)
def test_an_arm_that_cannot_start_is_refused(robot, words):
    with pytest.raises(ConfigError, match=words):
        check_robot(RemoteConfig(robot=robot))


def test_every_mistake_is_told_at_once_with_the_keys_that_cure_it():
    robot = RobotConfig(capsules=(HOOK,), start_deg=(0, 0, 500, 0, -300, 0))
    mirrored = MappingConfig(base_R_operator=((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    mistakes = find_mistakes(RemoteConfig(robot=robot, mapping=mirrored))
    assert [mistake.part for mistake in mistakes] == ["mapping", "collision", "start posture", "start posture"]
    assert "robot.capsules" in mistakes[1].cure
    assert all(mistake.sentence and mistake.cure for mistake in mistakes)


def test_a_stop_that_takes_too_long_is_refused_with_its_figures_and_the_cure():
    """Limits that are tightened make stops longer, up to `safety.longest_stop_ms` as computed from them."""
    robot = RobotConfig(jerk_rad_s3=40.0)
    with pytest.raises(ConfigError) as refused:
        check_robot(RemoteConfig(robot=robot))
    (sentence,) = str(refused.value).splitlines()
    assert "joint_5 may take 1050 ms to stop, from 3.02 rad/s with 20 rad/s² and 40 rad/s³" in sentence
    assert "safety.longest_stop_ms allows 600" in sentence
    assert "robot.jerk_rad_s3" in sentence
    assert "robot.speed = 0.29 or less" in sentence
    check_robot(RemoteConfig(robot=replace(robot, speed=0.29)))
    check_robot(RemoteConfig(robot=robot, safety=SafetyConfig(longest_stop_ms=1050.0)))
    assert find_mistakes(RemoteConfig(robot=robot, safety=SafetyConfig(longest_stop_ms=1049.0)))[0].part == "stopping"


@pytest.mark.parametrize(
    ("box", "words"),
    [
        (
            {"workspace_min_m": (-1000.0,) * 3, "workspace_max_m": (1000.0,) * 3},
            "2000 m along x, and the tool reaches over 1.69",
        ),
        (
            {"workspace_min_m": (0.1, -0.9, 0.2), "workspace_max_m": (0.8, 0.9, 1.1)},
            "1.8 m along y, .* from -0.85 to 0.85",
        ),
        (
            {"workspace_min_m": (0.1, -0.5, -0.6), "workspace_max_m": (0.8, 0.5, 1.2)},
            "1.8 m along z, .* from -0.52 to 1.18",
        ),
    ],
)
def test_a_box_that_is_larger_than_the_arms_reach_is_refused(box, words):
    mistakes = find_mistakes(RemoteConfig(safety=SafetyConfig(**box)))
    assert {mistake.part for mistake in mistakes} == {"workspace"}
    assert re.search(words, mistakes[0].sentence), mistakes


def test_the_start_says_in_one_line_what_is_not_guarded():
    bare = RemoteConfig(
        robot=RobotConfig(capsules=()),
        safety=SafetyConfig(collision=CollisionConfig(fixtures=()), workspace_max_m=(0.9, 0.55, 1.1)),
    )
    for config, level in ((RemoteConfig(), "info"), (bare, "warning")):
        with capture_logs() as lines:
            say_what_is_not_guarded(config)
        (line,) = lines
        assert (line["event"], line["log_level"]) == ("not guarded", level)
        assert "people" in line["what"]
    for part in ("safety.collision.fixtures is empty", "robot.capsules is empty", "x up to 0.9 m"):
        assert part in line["what"]


def test_the_process_that_enforces_the_limits_refuses_them_too():
    """It is also where 'farhand driver test' and the experiments take them from."""
    with pytest.raises(ConfigError, match="may take 7090 ms to stop"):
        setup_of(RemoteConfig(robot=RobotConfig(jerk_rad_s3=1.0)))


def test_the_default_gripper_is_carried_by_whatever_frame_carries_the_tool(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text((ARMS / "offset_wrist.urdf").read_text().replace("tool0", "l6"))
    robot = RobotConfig(model=str(urdf), tool_frame="l6", acceleration_rad_s2=(10.0,))
    check_robot(RemoteConfig(robot=robot))


def test_a_moving_link_without_inertia_is_refused_where_it_would_be_simulated(tmp_path):
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(re.sub(r"<inertial>.*</inertial>", "", (ARMS / "offset_wrist.urdf").read_text()))
    (mistake,) = find_mistakes(RemoteConfig(robot=RobotConfig(model=str(urdf), acceleration_rad_s2=(10.0,))))
    assert "'shoulder'" in mistake.sentence
    assert "<inertial>" in mistake.sentence


def test_the_guides_configuration_is_without_mistakes(tmp_path):
    (tmp_path / "tests").symlink_to(ROOT / "tests")  # as in Farhand's own folder
    guide = (ROOT / "docs" / "another-arm.md").read_text()
    path = tmp_path / "my-arm.toml"
    begin = guide.index("    [robot]\n")
    path.write_text(textwrap.dedent(guide[begin : guide.index("    farhand doctor", begin)]))
    config = load_config(RemoteConfig, path)
    assert config.safety.collision.fixtures[0].max_m == (1.0, 0.6, 0.0)
    check_robot(config)


def test_a_file_of_the_same_name_in_the_working_folder_is_never_taken_for_the_arm(tmp_path, monkeypatch):
    (tmp_path / "cell").mkdir()
    (tmp_path / "cell" / "arm.toml").write_text('[robot]\nmodel = "arm.urdf"\nacceleration_rad_s2 = [10.0]\n')
    (tmp_path / "arm.urdf").write_text((ARMS / "offset_wrist.urdf").read_text())
    monkeypatch.chdir(tmp_path)
    config = load_config(RemoteConfig, Path("cell/arm.toml"))
    (mistake,) = find_mistakes(config)
    assert f"there is no {tmp_path / 'cell' / 'arm.urdf'}; put it there" in mistake.sentence
    with pytest.raises(ConfigError, match=r"there is no .*/cell/arm\.urdf"):
        load_arm(config.robot)


def test_a_simulated_cell_that_does_not_fit_the_arm_is_refused_and_a_real_one_does_not_ask():
    robot = RobotConfig(**SEVEN)
    (mistake,) = find_mistakes(RemoteConfig(robot=robot))
    assert mistake.part == "simulated cell"
    assert "7 joints; give simulation.arm" in mistake.sentence
    check_robot(RemoteConfig(robot=robot, video=REAL, driver=DriverConfig(name="kinematic")))


def test_a_mirrored_mapping_is_refused():
    mirrored = MappingConfig(base_R_operator=((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    with pytest.raises(ConfigError, match="not a proper rotation"):
        check_robot(RemoteConfig(mapping=mirrored))


def test_a_mark_that_still_stands_tells_of_an_unordered_end(tmp_path, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    first = CrashMarker("cell")
    assert not first.set()
    second = CrashMarker("cell")
    assert second.set()
    assert not CrashMarker("another").set()
    second.clear()
    assert not CrashMarker("cell").set()


def test_the_mark_of_a_site_that_still_runs_tells_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    with subprocess.Popen([sys.executable, "-c", RUNNING_SITE], stdout=subprocess.PIPE, cwd=ROOT) as other:
        present(other.stdout).readline()
        own = CrashMarker("cell")
        assert not own.set()
        own.clear()
        other.kill()
    assert CrashMarker("cell").set()


def test_a_site_started_by_hand_keeps_its_mark_through_a_power_cut(tmp_path, monkeypatch):
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    CrashMarker("cell").set()
    assert len(list((tmp_path / "farhand" / "unfinished" / "cell").iterdir())) == 1


def test_a_folder_that_cannot_be_written_is_named_with_its_cure(tmp_path, monkeypatch):
    (tmp_path / "unfinished").touch()
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    with pytest.raises(ConfigError, match="STATE_DIRECTORY"):
        CrashMarker("cell").set()


def test_another_mode_of_engagement_changes_nothing_else():
    config = RemoteConfig(cell="lab").engaging(EngagementMode.AUTOMATIC)
    assert config.engagement.mode is EngagementMode.AUTOMATIC
    assert config.engaging(EngagementMode.ON_REQUEST) == RemoteConfig(cell="lab")


@pytest.mark.parametrize("driver", ["kinematic", "simulated"])
def test_a_driver_without_options_refuses_each_with_its_cure(driver):
    options = DriverConfig(name=driver, options={"foo": 1, "bar": "x"})
    with pytest.raises(ConfigError) as told:
        check_robot(RemoteConfig(driver=options))
    foo, bar = str(told.value).splitlines()
    assert foo == "driver.options.foo: this driver has no options; leave it out, or set driver.options={}"
    assert bar.startswith("driver.options.bar: ")
    check_robot(load_config(RemoteConfig, None, (f"driver.name={driver}", "driver.options={}")))


@pytest.mark.parametrize(
    ("settings", "refused"),
    [
        (("driver.name=simulated",), False),
        (("driver.name=kinematic",), False),
        (("driver.name=c500c", "driver.emulate=true"), False),
        (("driver.name=franka", "driver.emulate=true"), False),
        (("driver.name=franka", "driver.options.host=172.16.0.2"), True),
        (("driver.name=c500c",), True),
        (("driver.name=mine",), True),
        (("driver.name=mine", "engagement.automatic_accepted=yes"), True),
        (("driver.name=mine", f"engagement.automatic_accepted={ACCEPTANCE}"), False),
    ],
)
def test_automatic_engagement_of_a_real_robot_needs_its_acceptance(settings, refused):
    load_config(RemoteConfig, None, settings)
    given = (*settings, "engagement.mode=automatic")
    if not refused:
        assert load_config(RemoteConfig, None, given).engagement.mode is EngagementMode.AUTOMATIC
        return
    with pytest.raises(ConfigError) as error:
        load_config(RemoteConfig, None, given)
    assert f"automatic_accepted = {ACCEPTANCE!r}" in str(error.value)


def test_engagement_is_on_request_by_default():
    assert RemoteConfig().engagement.mode is EngagementMode.ON_REQUEST


@pytest.mark.parametrize(
    ("kind", "mesh", "part", "words"),
    [
        ("collision", "package://maker/l1.stl", "collision", "could not be found"),
        ("visual", "package://maker/l1.stl", "simulated cell", "opening file 'package:/+maker"),
        ("visual", "l1.dae", "simulated cell", "no decoder"),
    ],
)
def test_what_is_refused_of_a_makers_meshes_names_the_import(tmp_path, kind, mesh, part, words):
    (tmp_path / "l1.dae").write_text("<COLLADA/>")
    shape = f'<{kind}><geometry><mesh filename="{mesh}"/></geometry></{kind}>'
    urdf = tmp_path / "published.urdf"
    own = (ARMS / "seven_axes.urdf").read_text()
    urdf.write_text(own.replace('<link name="l1"/>', f'<link name="l1">{shape}</link>'))
    simulation = CellConfig(
        arm=ArmConfig(armature_kg_m2=(0.1,) * 7, coulomb_n_m=(0.1,) * 7, viscous_n_m_s=(0.1,) * 7),
        servo=ServoConfig(max_acceleration_rad_s2=(12.0,) * 7),
    )
    robot, safety = RobotConfig(**SEVEN | {"model": str(urdf)}), SafetyConfig(collision=CollisionConfig(fixtures=()))
    found = find_mistakes(RemoteConfig(robot=robot, safety=safety, simulation=simulation))
    mistakes = {mistake.part: mistake.sentence for mistake in found}
    assert re.search(words, mistakes[part])
    assert f"farhand arm import {urdf} --out arm.toml" in mistakes[part]
