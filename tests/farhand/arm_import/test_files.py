"""What an import writes: meshes beside its files, by names that do not clash, and never over what a user made."""

from pathlib import Path

import numpy as np
import pytest

from common.errors import ConfigError, ModelError
from farhand.arm_import.description.elements import Shape, Sphere, UrdfLink, UrdfMesh, UrdfRobot
from farhand.arm_import.files import Places, read_urdf
from farhand.arm_import.writing.manifest import with_manifest
from farhand.arm_import.writing.urdf import gather_meshes

SOURCE = Path("maker.urdf")


def contents(meshes, name="my--arm"):
    others = {f"{name}.toml": b"[robot]\n", **{f"{name}_meshes/{mesh}": mesh.encode() for mesh in meshes}}
    return {**others, f"{name}.urdf": with_manifest(b"<robot/>\n", f"{name}.urdf", others)}


@pytest.fixture
def places(tmp_path):
    """Of an earlier import."""
    places = Places.around(tmp_path / "my--arm.toml", SOURCE)
    places.check(SOURCE)
    places.write(contents(["a.stl", "b.stl"]))
    return places


def test_what_an_earlier_import_wrote_is_replaced_and_what_it_left_goes(places):
    places.check(SOURCE)
    places.write(contents(["b.stl", "c.stl"]))
    assert sorted(mesh.name for mesh in places.meshes.iterdir()) == ["b.stl", "c.stl"]
    places.check(SOURCE)
    places.write(contents([]))
    assert not places.meshes.exists()
    places.check(SOURCE)


def test_what_an_import_wrote_is_no_makers_file(places):
    with pytest.raises(ModelError, match=r"my--arm\.urdf was written by farhand arm import; give the maker's file"):
        read_urdf(places.urdf)


@pytest.mark.parametrize("name", ["my--arm.toml", "my--arm.urdf", "my--arm_meshes/a.stl", "my--arm_meshes/notes.txt"])
def test_what_a_user_changed_or_added_is_kept(places, name):
    file = places.toml.parent / name
    file.write_bytes((file.read_bytes() if file.exists() else b"").replace(b"robot", b"robots") + b"mine")
    with pytest.raises(ConfigError, match=f"{name} exists already.*give another name, or move it away first"):
        places.check(SOURCE)


def test_files_of_the_same_names_that_no_import_wrote_are_kept(tmp_path):
    places = Places.around(tmp_path / "arm.toml", SOURCE)
    places.meshes.mkdir()
    (places.meshes / "link.stl").touch()
    with pytest.raises(ConfigError, match=r"arm_meshes/link\.stl exists already"):
        places.check(SOURCE)
    (places.meshes / "link.stl").unlink()
    places.check(SOURCE)
    places.urdf.write_text("<robot/>")
    with pytest.raises(ConfigError, match=r"arm\.urdf exists already"):
        places.check(SOURCE)


def test_a_file_that_was_put_there_meanwhile_is_not_removed(places):
    (places.meshes / "mine.stl").touch()
    places.write(contents(["b.stl"]))
    assert sorted(mesh.name for mesh in places.meshes.iterdir()) == ["b.stl", "mine.stl"]


@pytest.mark.parametrize(("urdf", "written"), [("panda.urdf", "panda-arm.urdf"), ("maker/panda.urdf", "panda.urdf")])
def test_the_makers_own_file_is_never_written_over(urdf, written, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert Places.around(Path("panda.toml"), Path(urdf)).urdf == Path(written)


def test_meshes_of_one_name_get_names_of_their_own_and_one_that_is_used_twice_is_one_file():
    names = ["/a/visual/base.obj", "/a/collision/base.stl", "/b/Base.STL", "/a/arm.stl", "/a/visual/base.obj"]
    shapes = tuple(Shape(np.eye(4), UrdfMesh(name, (0.001, 0.001, 0.001))) for name in names)
    ball = Shape(np.eye(4), Sphere(0.1))
    robot = UrdfRobot("r", "l", {"l": UrdfLink("l", visuals=(*shapes[:2], ball), collisions=shapes[2:])})
    moved, files = gather_meshes(robot, "r_meshes")
    assert {name: str(file) for name, file in files.items()} == {
        "r_meshes/base.obj": "/a/visual/base.obj",
        "r_meshes/base_2.stl": "/a/collision/base.stl",
        "r_meshes/Base_3.STL": "/b/Base.STL",
        "r_meshes/arm.stl": "/a/arm.stl",
    }
    link = moved.links["l"]
    assert [shape.geometry for shape in (*link.visuals[:2], *link.collisions)] == [
        UrdfMesh(name, (0.001, 0.001, 0.001)) for name in (*files, "r_meshes/base.obj")
    ]
    assert link.visuals[2] is ball
