"""Meshes of collision elements: seen from the URDF's folder alone; what stands against one is said with its cure."""

from pathlib import Path

import pytest

from common.errors import ModelError
from farhand.replay.recorded_cycles import with_urdf
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import load_model
from remote_site.safety.collision import CollisionModel
from remote_site.safety.config import CollisionConfig
from tests.farhand.arm_import.published import box_stl
from tests.remote_site.arms_followed import ARMS

SHAPE = '<collision><geometry><mesh filename="arm_meshes/l1.stl"/></geometry></collision>'


@pytest.fixture
def robot(tmp_path):
    """Seven axes whose first link has a mesh, in a folder that is not the working one."""
    folder = tmp_path / "cell"
    (folder / "arm_meshes").mkdir(parents=True)
    (folder / "arm_meshes" / "l1.stl").write_bytes(box_stl((0.1, 0.1, 0.1), (0.0, 0.0, 0.0)))
    own = (ARMS / "seven_axes.urdf").read_text()
    (folder / "arm.urdf").write_text(own.replace('<link name="l1"/>', f'<link name="l1">{SHAPE}</link>'))
    return RobotConfig(model=str(folder / "arm.urdf"), acceleration_rad_s2=(10.0,), start_deg=(0.0,) * 7)


def distances(robot: RobotConfig) -> CollisionModel:
    return CollisionModel.from_urdf(robot.urdf, load_model(robot), robot.capsules, CollisionConfig())


def test_a_mesh_is_that_of_the_urdfs_folder_and_moves_with_it(robot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    distances(robot)
    moved = (tmp_path / "cell").rename(tmp_path / "moved")
    distances(RobotConfig(model=str(moved / "arm.urdf")))
    (moved / "arm_meshes").rename(tmp_path / "arm_meshes")
    with pytest.raises(ModelError, match=rf"names the mesh {moved}/arm_meshes/l1\.stl, .* no such file; bring the fol"):
        distances(RobotConfig(model=str(moved / "arm.urdf")))


def test_what_the_library_says_of_a_mesh_is_cut_to_what_a_user_can_use(robot):
    mesh = robot.urdf.parent / "arm_meshes" / "l1.stl"
    mesh.write_text("hello")
    with pytest.raises(ModelError) as refused:
        distances(robot)
    assert f"Could not load resource {mesh} File is too small; give meshes as STL" in str(refused.value)
    assert "assimp" not in str(refused.value)
    assert "Hint" not in str(refused.value)


def test_a_recorded_arms_meshes_are_those_of_the_folder_where_it_was_recorded(robot, tmp_path):
    recorded = robot.urdf.read_bytes()
    robot.urdf.write_bytes(recorded + b"<!-- changed since -->")
    (tmp_path / "replayed").mkdir()
    again = with_urdf(RemoteConfig(robot=robot), recorded, tmp_path / "replayed").robot
    assert again.urdf.parent == Path(tmp_path / "replayed")
    distances(again)
