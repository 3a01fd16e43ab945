"""A maker's URDF becomes a configuration that the remote site starts with, from any folder."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from common.config.loading import load_config
from common.errors import ConfigError, ModelError
from farhand.arm_import.description.packages import search_path
from farhand.arm_import.import_arm import ImportRequest, import_arm
from farhand.cli import app
from farhand.deployment.schemas import schema_of
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.checks import find_mistakes, find_unguarded
from remote_site.safety.collision import CollisionModel
from tests.farhand.arm_import.published import FINGERS, PACKAGE, publish, unseen


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("imported")
    out = folder / "arm.toml"
    shown = []
    lines = import_arm(ImportRequest(publish(folder / "ws"), out, points="down"), lambda *work: shown.append(work))
    return out, lines, shown


@pytest.fixture
def config(imported, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return load_config(RemoteConfig, imported[0])


@pytest.mark.slow
def test_the_site_starts_with_it_from_any_folder(config):
    assert find_mistakes(config) == []


def test_editors_know_its_keys(imported):
    named = imported[0].read_text().partition("\n")[0].removeprefix("#:schema ")
    assert json.loads((imported[0].parent / named).read_text()) == json.loads(json.dumps(schema_of(RemoteConfig)))


def test_only_the_arm_moves_and_the_rest_is_said_with_its_reason(config, imported):
    model, _ = load_arm(config.robot)
    assert model.joint_names == tuple(
        f"{name}_joint" for name in ("shoulder", "upper", "fore", "wrist_a", "wrist_b", "wrist_c")
    )
    text = "\n".join(imported[1])
    assert "locked: finger_left_joint at 0.01 (a gripper's)" in text
    assert "locked: finger_right_joint at 0.01 (follows finger_left_joint)" in text
    assert f"dropped: the visual package://{PACKAGE}/meshes/base_link.dae: MuJoCo reads .stl and .obj, not .dae" in text
    assert "dropped: 4 more visuals like these" in text
    assert "estimated: mass and inertia of shoulder, upper, fore, wrist_a, wrist_b, wrist_c" in text
    assert "assumed: 500 rad/s³ for every joint" in text
    assert "tool: hand_tcp, guessed" in text
    assert [line for line in imported[1] if line.startswith("  farhand")] == [
        f"  farhand doctor --config {imported[0]}",
        f"  farhand loopback --config {imported[0]}",
        f"  farhand limits --config {imported[0]} --factor 0.1",
        f"  farhand remote --config {imported[0]} --driver NAME --set robot.limits_factor=0.1",
    ]
    meshes = imported[0].with_name("arm_meshes")
    size = sum(mesh.stat().st_size for mesh in meshes.iterdir())
    assert f"{meshes} (7 meshes, {size / 1e6:.1f} MB); to move them, keep them together" in imported[1][1]


def test_the_files_are_moved_together_and_need_nothing_of_the_makers(imported, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(imported[0].parent, tmp_path / "moved", ignore=shutil.ignore_patterns("ws"))
    config = load_config(RemoteConfig, Path("moved/arm.toml"))
    assert find_mistakes(config) == []
    text = config.robot.urdf.read_text()
    assert 'filename="arm_meshes/shoulder.stl"' in text
    assert str(imported[0].parent) not in text.split("<robot")[1]
    shutil.rmtree(tmp_path / "moved" / "arm_meshes")
    mistakes = find_mistakes(config)
    assert "names the mesh" in mistakes[0].sentence
    assert "bring the folder of its meshes" in mistakes[0].sentence


def test_limits_tells_what_the_import_assumed_from_what_the_maker_states(imported):
    told = CliRunner().invoke(app, ["limits", "--config", str(imported[0]), "--factor", "0.1", "--json"]).output
    limits = json.loads(told)["limits"]
    assert "assumed by farhand arm import times robot.limits_factor = 0.1" in limits["jerk_rad_s3"]["from"]
    assert "robot.acceleration_rad_s2, assumed by farhand arm import" in limits["acceleration_rad_s2"]["from"]
    assert "assumed" not in limits["speed_rad_s"]["from"]
    assert "A465" not in told


def test_every_part_of_the_work_is_shown_to_its_end(imported):
    ends = {what: (done, total) for what, done, total in imported[2]}
    assert list(ends) == [
        "links covered",
        "start postures tried, the tool down",
        "boxes tried",
    ]
    assert all(done == total for done, total in ends.values())
    assert ends["links covered"] == (11, 11)


def test_the_tool_centre_point_is_the_frame_and_the_tool_points_as_asked(config):
    model, _ = load_arm(config.robot)
    pose = model.forward(config.robot.start)
    data = model.pin_model.createData()
    import pinocchio as pin

    pin.framesForwardKinematics(model.pin_model, data, config.robot.start)
    frame = data.oMf[model.pin_model.getFrameId("hand_tcp")]
    assert pose[:3, 3] == pytest.approx(frame.translation, abs=1e-6)
    assert pose[:3, 2] == pytest.approx([0, 0, -1], abs=0.02)


def test_the_start_is_clear_and_within_the_box(config):
    model, limits = load_arm(config.robot)
    robot, safety = config.robot, config.safety
    collision = CollisionModel.from_urdf(robot.urdf, model, robot.capsules, safety.collision)
    assert collision.distance(robot.start) > safety.collision.margin_m
    tool = model.position(robot.start)
    assert (np.array(safety.workspace_min_m) < tool).all()
    assert (tool < np.array(safety.workspace_max_m)).all()
    assert (limits.lower + 0.1 < robot.start).all()
    assert (robot.start < limits.upper - 0.1).all()


def test_nothing_of_the_arm_and_its_tool_is_left_unguarded(config):
    assert find_unguarded(config) == ()
    assert {capsule.link for capsule in config.robot.capsules} == {
        "hand",
        "finger_left_of_published",  # the simulated gripper has a finger_left of its own
        "finger_right_of_published",
    }


def test_a_file_that_is_there_is_kept(imported):
    with pytest.raises(ConfigError, match="exists already"):
        import_arm(ImportRequest(imported[0].with_suffix(".urdf"), imported[0]), unseen)


def test_a_folder_is_no_arm(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    refused = CliRunner().invoke(app, ["arm", "import", "."]).exception
    assert str(refused) == ". is a folder; give the path of a URDF file"


def test_a_mistake_that_is_found_in_what_was_made_of_the_makers_file_names_that(tmp_path, monkeypatch):
    def unreadable(path, *_):
        raise ModelError(f"cannot read the robot model {path}: no such thing; give a URDF file")

    monkeypatch.setattr(ArmModel, "from_urdf", unreadable)
    urdf = publish(tmp_path)
    with pytest.raises(ModelError, match=f"^cannot read the robot model {urdf}: no such thing"):
        import_arm(ImportRequest(urdf, tmp_path / "arm.toml"), unseen)


def test_no_angle_is_told_as_minus_nothing(imported):
    told = next(line for line in imported[1] if line.startswith("computed: start posture"))
    assert "-0," not in told
    assert "-0 " not in told


def test_a_mesh_in_an_unknown_package_names_the_option(tmp_path):
    urdf = publish(tmp_path)
    lone = tmp_path / "elsewhere" / "arm.urdf"
    lone.parent.mkdir()
    lone.write_text(urdf.read_text())
    (tmp_path / PACKAGE).rename(tmp_path / "renamed")
    with pytest.raises(ModelError, match=f"link base_link.*--package {PACKAGE}=FOLDER"):
        import_arm(ImportRequest(lone, tmp_path / "arm.toml"), unseen)
    assert not (tmp_path / "arm.toml").exists()


def test_ros_tells_where_its_packages_are():
    environment = {"ROS_PACKAGE_PATH": "/a:/b/c", "AMENT_PREFIX_PATH": "/opt/ros"}
    assert [str(path) for path in search_path(environment)] == ["/a", "/b/c", "/opt/ros/share"]


def test_an_arm_that_cannot_turn_its_tool_names_what_it_lacks(tmp_path):
    short = publish(tmp_path, end=FINGERS)
    text = short.read_text().replace('name="wrist_b_joint" type="revolute"', 'name="wrist_b_joint" type="fixed"')
    short.write_text(text)
    with pytest.raises(ModelError, match=r"has 5 moving joints .* 6 or more"):
        import_arm(ImportRequest(short, tmp_path / "arm.toml", points="down"), unseen)
