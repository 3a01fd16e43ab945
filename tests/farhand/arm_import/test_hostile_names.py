"""A maker's words are names and comments in what an import writes, and never anything else."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from common.errors import ModelError
from farhand.arm_import.choices.box import ReachedBox
from farhand.arm_import.choices.cell import joint_numbers, scene, table
from farhand.arm_import.choices.posture import Start
from farhand.arm_import.choices.reaching import PostureQuality
from farhand.arm_import.choices.tool import Tool
from farhand.arm_import.description.arm import ChosenArm
from farhand.arm_import.description.elements import Joint, Limit, Shape, UrdfLink, UrdfMesh, UrdfRobot
from farhand.arm_import.description.reading import read_description
from farhand.arm_import.design import Design
from farhand.arm_import.import_arm import ImportRequest, import_arm
from farhand.arm_import.prepared import PreparedArm
from farhand.arm_import.shapes.capsule import Capsule
from farhand.arm_import.writing.manifest import digests_in, is_as_written, with_manifest
from farhand.arm_import.writing.toml import toml_text
from farhand.arm_import.writing.urdf import gather_meshes, urdf_text
from remote_site.kinematics.limits import JointLimits
from tests.farhand.arm_import.published import publish, unseen

INJECTED = "j4\n[engagement]\nmode = 'automatic'\naccept_unattended = true\n[links]\ncontrol = 'tcp/0.0.0.0:7447'\n"
SHOWN = st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1, max_size=64)
LIMIT = Limit(-1.0, 1.0, 1.0, 10.0, None, None)


def made_design(name: str, frame: str, link: str) -> Design:
    """A design of one joint, with words of a maker wherever a design has some; its numbers mean nothing."""
    joint = Joint(name, "revolute", "base", link, np.eye(4), np.eye(3)[2], LIMIT)
    robot = UrdfRobot(name, "base", {"base": UrdfLink("base"), link: UrdfLink(link)}, (joint,))
    capsule = Capsule(np.zeros(3), np.ones(3), 0.1)
    tool = Tool(frame, np.eye(4), own=True, capsules=((link, capsule),), notes=(name,))
    written = replace(robot, joints=(replace(joint, limit=replace(LIMIT, jerk=500.0)),))
    prepared = PreparedArm(written, ChosenArm(robot, (joint,), frame, False, ()), tool, (name,), (name,), (link,))
    one, box = np.ones(1), ReachedBox(np.zeros(3), np.ones(3), 0.005)
    start = Start(np.zeros(1), "down", False, 0.5, box, PostureQuality(2.0, 0.1, 1.0))
    return Design(
        prepared, (), 1.0, JointLimits((name,), -one, one, one, one, one), 0.5, joint_numbers((joint,)), (table(1.0),),
        ((link, frame),), (0.01, 0.02), start, np.ones(3), scene(np.ones(3), 1.0, 0.5, points_down=True), False,
    )  # fmt: skip


@given(*[st.text(min_size=1)] * 5)
@example(*[INJECTED] * 5)
def test_the_configuration_has_the_designs_values_and_nothing_else(name, frame, link, urdf, line):
    plain = tomllib.loads(toml_text(made_design("n", "f", "l"), "u", ["h"]))
    robot = plain["robot"] | {"model": urdf, "tool_frame": frame}
    robot["capsules"] = [{**capsule, "link": link} for capsule in robot["capsules"]]
    collision = plain["safety"]["collision"] | {"ignored_pairs": [[link, frame]]}
    expected = plain | {"robot": robot, "safety": plain["safety"] | {"collision": collision}}
    assert tomllib.loads(toml_text(made_design(name, frame, link), urdf, [line, name])) == expected


@given(SHOWN, SHOWN, st.text())
@example("<b>&\"'", "]]>--", INJECTED + "--><robot/>")
def test_the_arms_file_has_the_same_names_whatever_its_comment_says(name, link, comment):
    robot = made_design(name, "f", link).prepared.robot
    if link == "base":
        return
    text = with_manifest(urdf_text(robot, [comment]).encode(), f"{name}.urdf", {f"{comment}.toml": b""})
    found = read_description(text, "arm.urdf")
    assert [found.name, *(joint.name for joint in found.joints)] == [name, name]
    assert list(found.links) == ["base", link]
    assert is_as_written(f"{name}.urdf", text, digests_in(text))


@pytest.mark.parametrize(
    ("element", "place"),
    [
        ('<link name="{}"/>', "<link> number 3 in the file: its name"),
        ('<joint name="{}" type="fixed"><parent link="a"/><child link="b"/></joint>', "<joint> number 2 .* its name"),
        ('<joint name="k" type="{}"><parent link="a"/><child link="b"/></joint>', "<joint> number 2 .* its type"),
        ('<joint name="k" type="fixed"><parent link="{}"/><child link="b"/></joint>', "<parent> number 2 .* its link"),
        ('<joint name="k" type="fixed"><parent link="a"/><child link="{}"/></joint>', "<child> number 2 .* its link"),
        ('<joint name="k" type="floating"><mimic joint="{}"/></joint>', "<mimic> number 1 .* its joint"),
        ('<material name="{}"/>', "<material> number 1 .* its name"),
    ],
)
@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("j4&#10;[engagement]", r"has characters that do not show: 'j4\\n\[engagement\]'"),
        ("j&#x2028;4", r"has characters that do not show: 'j\\u20284'"),
        ("j&#x202e;4", r"has characters that do not show: 'j\\u202e4'"),
        ("j" * 65, "has 65 characters.*at most 64"),
    ],
)
def test_a_name_that_would_not_stay_one_is_refused_when_it_is_read(element, place, name, wrong):
    text = (
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed"><parent link="a"/>'
        f'<child link="b"/></joint>{element.format(name)}</robot>'
    )
    with pytest.raises(ModelError, match=f"arm.urdf: {place} {wrong}"):
        read_description(text.encode(), "arm.urdf")


def test_the_robots_own_name_and_a_meshs_file_are_names_too():
    with pytest.raises(ModelError, match="<robot> number 1 in the file: its name has characters that do not show"):
        read_description(b'<robot name="r&#10;x"/>', "arm.urdf")
    mesh = b'<visual><geometry><mesh filename="a&#10;b.stl"/></geometry></visual>'
    with pytest.raises(ModelError, match=r"<mesh> number 1 .* its filename has characters that do not show"):
        read_description(b'<robot name="r"><link name="a">' + mesh + b"</link></robot>", "arm.urdf")


def test_an_import_of_such_a_file_writes_nothing(tmp_path):
    urdf = publish(tmp_path / "ws")
    urdf.write_text(urdf.read_text().replace("wrist_b_joint", INJECTED.replace("\n", "&#10;")))
    with pytest.raises(ModelError, match="its name has characters that do not show"):
        import_arm(ImportRequest(urdf, tmp_path / "arm.toml", points="down"), unseen)
    assert [path.name for path in tmp_path.iterdir()] == ["ws"]


@given(st.lists(st.text(st.characters(exclude_characters="/\0", exclude_categories=["Cs"]), min_size=1), max_size=4))
@example(["x" * 250, "x" * 250 + ".stl", "a\nb.stl", "a\\..\\b", "\u202elts.exe"])
def test_meshes_stay_in_their_folder_under_names_of_their_own(names):
    files = [f"/maker/{name}" for name in names if name not in {".", ".."}]
    shapes = tuple(Shape(np.eye(4), UrdfMesh(file)) for file in files)
    _, written = gather_meshes(UrdfRobot("r", "l", {"l": UrdfLink("l", visuals=shapes)}), "r_meshes")
    assert {str(file) for file in written.values()} == {str(Path(file)) for file in files}
    for name in written:
        assert Path("/out", name).resolve().parent == Path("/out/r_meshes")
        assert name.isprintable()
        assert len(Path(name).stem) <= 68
