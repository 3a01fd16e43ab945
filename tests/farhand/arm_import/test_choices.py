"""Where the tool sits, which box is the largest, what an arm's own gaps leave of the margins."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from common.errors import ModelError
from farhand.arm_import.choices.box import Grid, largest_box
from farhand.arm_import.choices.cell import fitting_speed, joint_numbers, margins
from farhand.arm_import.choices.tool import FRAME, GRIPPER_M, choose_tool, pose_from, with_mount
from farhand.arm_import.description.arm import choose_arm
from farhand.arm_import.description.elements import Limit, Shape, UrdfBox, UrdfLink, with_free_names
from farhand.arm_import.description.reading import read_description
from farhand.arm_import.prepared import cover_links
from farhand.arm_import.shapes.links import cover_link
from remote_site.kinematics.limits import JointLimits
from tests.farhand.arm_import.published import unseen

ARM = """<robot name="r"><link name="base"/><link name="wrist"/><link name="last"/>{links}
  <joint name="a" type="revolute"><parent link="base"/><child link="wrist"/><axis xyz="0 1 0"/>{limit}</joint>
  <joint name="b" type="revolute"><parent link="wrist"/><child link="last"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 {sign}"/>{limit}</joint>{joints}</robot>"""
LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="100"/>'


def frame(name, origin, inside=""):
    joint = f'<joint name="{name}_fixed" type="fixed"><parent link="last"/><child link="{name}"/>{origin}</joint>'
    return f'<link name="{name}">{inside}</link>', joint


def tool_of(*frames, tool=None, sign=1, **options):
    links, joints = zip(*frames, strict=True) if frames else ((), ())
    text = ARM.format(links="".join(links), joints="".join(joints), limit=LIMIT, sign=sign)
    arm = choose_arm(read_description(text.encode(), "arm.urdf"), tool)
    return arm, choose_tool(arm, cover_links(arm, Path, unseen), **options)


def test_a_flange_along_z_is_taken_as_it_is_and_carries_the_gripper():
    arm, tool = tool_of(frame("tool0", '<origin xyz="0 0 0.05"/>'))
    assert (arm.tool, arm.guessed, tool.frame, tool.own, tool.notes) == ("tool0", True, "tool0", False, ())


@pytest.mark.parametrize(
    ("rpy", "axis"), [("0 1.5707963 0", "-x"), ("0 -1.5707963 0", "x"), ("1.5707963 0 0", "y"), ("3.1415927 0 0", "-z")]
)
@pytest.mark.parametrize("sign", [1, -1])
def test_a_tool_along_another_axis_gets_a_frame_of_its_own(rpy, axis, sign):
    arm, tool = tool_of(frame("ee_link", f'<origin xyz="0 0 0.05" rpy="{rpy}"/>'), sign=sign)
    assert tool.frame == FRAME
    assert f"the tool points along its {axis}," in tool.notes[0]
    pose = pose_from(with_mount(arm.description, arm.last_link, tool), "last", FRAME)
    assert pose[:3, 2] == pytest.approx([0, 0, 1], abs=1e-6)
    assert pose[:3, 3] == pytest.approx([0, 0, 0.05])
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)


def test_the_centre_of_the_files_own_tool_is_its_frame_and_the_gripper_ends_there():
    hand = '<collision><origin xyz="0 0 0.05"/><geometry><box size="0.04 0.1 0.1"/></geometry></collision>'
    tcp = frame("hand_tcp", '<origin xyz="0 0 0.12"/>')
    arm, tool = tool_of(frame("hand", '<origin xyz="0 0 0.02"/>', hand), tcp)
    assert (arm.tool, tool.own, tool.frame) == ("hand_tcp", True, FRAME)
    assert tool.last_T_mount[:3, 3] == pytest.approx([0, 0, 0.12 - GRIPPER_M])
    assert [link for link, _ in tool.capsules] == ["hand"]


def test_where_the_tools_own_link_is_named_its_end_is_the_centre():
    hand = '<collision><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.02" length="0.1"/></geometry></collision>'
    _, tool = tool_of(frame("hand", "", hand), tool="hand")
    assert tool.last_T_mount[2, 3] + GRIPPER_M == pytest.approx(0.1 + 0.05 - 0.01)
    assert "the tool centre point is taken 140 mm beyond it" in tool.notes[0]


def test_a_last_link_without_a_flange_ends_where_its_shape_does():
    arm, _ = tool_of()
    links = cover_links(arm, Path, unseen)
    body = UrdfLink("last", collisions=(Shape(np.eye(4), UrdfBox((0.02, 0.02, 0.1))),))
    tool = choose_tool(arm, links | {"last": cover_link(body, Path, moves=False)})
    assert tool.last_T_mount[2, 3] == pytest.approx(0.05)


def test_a_turned_tool_points_where_it_did():
    _, tool = tool_of(frame("tool0", ""), turned=True)
    assert tool.frame == FRAME
    assert tool.last_T_mount[:3, :3] == pytest.approx(np.diag([-1.0, -1.0, 1.0]))


def test_the_largest_box_holds_the_hands_room_and_no_place_that_is_not_reached():
    grid = Grid.around(np.array([0.5, 0.0, 0.4]), 1.0, 1.0)
    reached = np.ones(grid.size, dtype=bool)
    first, last = (np.array(cell) for cell in (grid.first, grid.last))
    assert grid.at(grid.start) == pytest.approx([0.5, 0.0, 0.4])
    assert grid.at(grid.last) - grid.at(grid.first) == pytest.approx([0.22, 0.44, 0.30])
    assert largest_box(reached, grid) == ((0, 0, 0), tuple(n - 1 for n in grid.size))
    reached[last[0] + 1, 0, 0] = False
    low, high = map(np.array, largest_box(reached, grid))
    assert (low <= first).all()
    assert (high >= last).all()
    assert reached[tuple(slice(a, b + 1) for a, b in zip(low, high, strict=True))].all()


def test_an_arms_own_gaps_are_outside_the_margins():
    assert margins(math.inf) == (0.01, 0.04)
    margin, slow = margins(0.0138)
    assert margin + 0.004 < 0.0138
    assert margin < slow < 0.0138


def test_what_a_simulation_needs_goes_by_the_efforts_unless_the_file_says_it():
    arm, _ = tool_of()
    weak = replace(arm.joints[1], limit=Limit(-1, 1, 1, 10, acceleration=4.0), friction=0.7)
    numbers = joint_numbers((arm.joints[0], weak))
    assert numbers.acceleration == (7.0, 4.0)
    assert numbers.armature == (0.25, 0.025)
    assert numbers.coulomb == (1.0, 0.7)


def test_a_quick_arm_is_slowed_until_its_stops_are_short_enough():
    def limits(velocity):
        return JointLimits(("j",), *(np.array([v]) for v in (-3.0, 3.0, velocity, 7.0, 500.0)))

    assert fitting_speed(limits(2.0)) == 1.0
    assert fitting_speed(limits(10.0)) < 0.4


def test_a_jerk_with_which_no_stop_is_short_enough_is_named_with_the_option_that_gives_it():
    slow = JointLimits(("lift",), *(np.array([v]) for v in (-3.0, 3.0, 3.0, 7.0, 1.0)))
    with pytest.raises(ModelError, match=r"lift would take \d+ ms to stop .* 1 rad/s³; 550 ms .* by --jerk where"):
        fitting_speed(slow)


def test_names_that_are_taken_are_changed_wherever_they_stand():
    text = ARM.format(links="", joints="", limit=LIMIT, sign=1)
    robot = with_free_names(read_description(text.encode(), "arm.urdf"), {"wrist", "b"})
    assert list(robot.links) == ["base", "wrist_of_r", "last"]
    assert [(j.name, j.parent, j.child) for j in robot.joints] == [
        ("a", "base", "wrist_of_r"),
        ("b_of_r", "wrist_of_r", "last"),
    ]
