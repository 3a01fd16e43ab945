"""What a URDF says is read, which of it is the arm is found, and what is wrong is named with its cure."""

import numpy as np
import pytest

from common.errors import ConfigError, ModelError
from farhand.arm_import.description.arm import check_joints, choose_arm
from farhand.arm_import.description.reading import read_description

LIMIT = '<limit lower="-1" upper="2" velocity="1" effort="10"/>'


def joint(name, parent, child, kind="revolute", inside=LIMIT, axis='<axis xyz="0 0 2"/>'):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{axis}{inside}</joint>'


def robot(*joints, links=()):
    named = dict.fromkeys([*links, *(word for text in joints for word in ends(text))])
    return f'<robot name="r">{"".join(f"<link name={chr(34)}{n}{chr(34)}/>" for n in named)}{"".join(joints)}</robot>'


def ends(text):
    return [part.split('"')[0] for part in text.split('link="')[1:]]


def read(text, source="arm.urdf"):
    return read_description(text.encode(), source)


def arm_of(side=""):
    return [joint(f"{side}j{k}", f"{side}l{k}" if k else "base", f"{side}l{k + 1}") for k in range(4)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot", "not XML"),
        (
            '<robot xmlns:xacro="http://x/xacro"><xacro:include filename="a"/></robot>',
            "xacro arm.urdf -o arm-expanded.urdf$",
        ),
        ("<mujoco/>", r"MJCF.*give the arm's URDF"),
        (robot(joint("a", "x", "y"), links=("z",)), "z, x are not joined"),
        (robot(joint("a", "x", "z"), joint("b", "y", "z")), "z is the child of two joints"),
        (robot(joint("a", "x", "y"), joint("b", "y", "x")), "no link that everything else hangs from"),
        (
            robot(joint("a", "x", "y")).replace('<link name="y"/>', ""),
            "joint a names the link 'y', which does not exist; add it",
        ),
        (robot(joint("a", "x", "y"), joint("a", "y", "z")), "^arm.urdf: two joints are called a; rename one$"),
        (robot(joint("a", "x", "y")).replace("<joint", '<link name="x"/><joint'), "arm.urdf: two links are called x"),
        (robot(joint("a", "x", "y", axis='<axis xyz="0 0 0"/>')), "joint a needs <axis"),
        (robot(joint("a", "x", "y", axis='<axis xyz="0 one 0"/>')), "'0 one 0' must be 3 numbers"),
        (robot(joint("a", "x", "y", kind="hinge")), "type 'hinge'; the types are fixed, revolute"),
    ],
)
def test_what_cannot_be_read_is_named(text, words):
    with pytest.raises(ModelError, match=words):
        read(text)


def test_an_origin_turns_about_the_fixed_axes_as_ros_says():
    text = robot(joint("a", "x", "y", inside=LIMIT + '<origin xyz="1 2 3" rpy="0 0 1.5707963"/>'))
    pose = read(text).joints[0].parent_T_joint
    assert pose[:3] == pytest.approx(np.array([[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3]]), abs=1e-6)


def test_two_arms_are_told_apart_by_the_tool_and_the_other_is_locked():
    both = read(robot(*arm_of("left_"), *arm_of("right_")))
    with pytest.raises(ModelError, match=r"2 chains begin at base.*--tool left_l4 or --tool right_l4"):
        choose_arm(both, None)
    chosen = choose_arm(both, "left_l4")
    assert [j.name for j in chosen.joints] == ["left_j0", "left_j1", "left_j2", "left_j3"]
    assert {lock.joint for lock in chosen.locked} == {"right_j0", "right_j1", "right_j2", "right_j3"}


def test_the_nearest_of_the_frames_that_exist_is_named():
    with pytest.raises(ConfigError, match=r"--tool l44: there is no such frame; did you mean l4\? The frames are base"):
        choose_arm(read(robot(*arm_of())), "l44")
    with pytest.raises(ConfigError, match="--tool nope: there is no such frame; the frames are base, l1"):
        choose_arm(read(robot(*arm_of())), "nope")


def hand_on(side=""):
    """An arm of six joints and a hand of two fingers whose joints are not named so."""
    six = [joint(f"{side}j{k}", f"{side}l{k}" if k else "torso", f"{side}l{k + 1}") for k in range(6)]
    palm = joint(f"{side}palm_fixed", f"{side}l6", f"{side}palm", kind="fixed", inside="")
    fingers = [
        joint(f"{side}{which}{k}", f"{side}{which}_link{k}" if k else f"{side}palm", f"{side}{which}_link{k + 1}")
        for which in ("index", "middle")
        for k in range(3)
    ]
    return [*six, palm, *fingers]


def test_an_arm_ends_where_its_hand_begins():
    chosen = choose_arm(read(robot(*hand_on())), None)
    assert [j.name for j in chosen.joints] == [f"j{k}" for k in range(6)]
    assert chosen.tool == "palm"
    assert len(chosen.locked) == 6
    with pytest.raises(ModelError, match=r"--tool left_palm or --tool right_palm$"):
        choose_arm(read(robot(*hand_on("left_"), *hand_on("right_"))), None)


def test_an_arm_of_too_few_joints_is_known_by_them():
    with pytest.raises(
        ModelError, match=r"the arm to l4 has 4 moving joints \(j0, j1, j2, j3\), .* 6 or more; .*--tool"
    ):
        check_joints(choose_arm(read(robot(*arm_of())), None))
    check_joints(choose_arm(read(robot(*hand_on())), None))


def test_what_an_earlier_import_assumed_is_not_what_the_maker_states():
    def limit_of(text):
        return read(robot(joint("a", "x", "y", inside=text))).joints[0].limit

    assumed = '<limit lower="-1" upper="2" velocity="1" effort="10" jerk="{}" assumed_jerk="500"/>'
    assert limit_of(assumed.format(500)).jerk is None
    assert limit_of(assumed.format(3750)).jerk == 3750


def test_locked_joints_stand_where_asked_and_followers_follow():
    fingers = [
        joint("grip_joint", "l4", "pad", inside=LIMIT),
        joint("other", "l4", "pad2", inside=LIMIT + '<mimic joint="grip_joint" multiplier="-0.5" offset="0.1"/>'),
    ]
    chosen = choose_arm(read(robot(*arm_of(), *fingers)), None, positions={"grip_joint": 0.6})
    assert {lock.joint: pytest.approx(lock.position) for lock in chosen.locked} == {"grip_joint": 0.6, "other": -0.2}
    fixed = {j.name: j for j in chosen.description.joints}
    assert fixed["grip_joint"].kind == "fixed"
    assert fixed["grip_joint"].parent_T_joint[:2, :2] == pytest.approx(
        np.array([[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]])
    )
    with pytest.raises(ConfigError, match="--lock j1: no such joint can be locked; there are grip_joint, other"):
        choose_arm(read(robot(*arm_of(), *fingers)), None, positions={"j1": 0.0})


def test_a_base_that_rolls_is_left_out_by_name():
    rolling = read(robot(joint("wheels", "world", "base", kind="planar", inside=""), *arm_of()))
    with pytest.raises(ModelError, match=r"wheels \(planar\).*--base base"):
        choose_arm(rolling, "l4")
    chosen = choose_arm(rolling, "l4", "base")
    assert chosen.description.root == "base"
    assert len(chosen.joints) == 4


@pytest.mark.parametrize("limit", ["", '<limit velocity="1"/>', '<limit lower="1" upper="0" velocity="1"/>'])
def test_a_joint_without_limits_is_named_with_what_it_needs(limit):
    text = robot(joint("bare", "base", "l0", inside=limit), joint("b", "l0", "l1"))
    with pytest.raises(ModelError, match="bare: a joint of the arm needs <limit lower"):
        choose_arm(read(text), None)


@pytest.mark.parametrize(("links", "kind"), [(501, "fixed"), (202, "revolute"), (3000, "fixed")])
def test_more_links_than_any_robot_has_are_refused_at_once(links: int, kind: str) -> None:
    limit = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
    joints = "".join(
        f'<joint name="j{k}" type="{kind}"><parent link="l{k}"/><child link="l{k + 1}"/>{limit}</joint>'
        for k in range(links - 1)
    )
    text = f'<robot name="r">{"".join(f"""<link name="l{k}"/>""" for k in range(links))}{joints}</robot>'
    with pytest.raises(ModelError, match=f"has {links} links .* give the file of the arm alone"):
        read_description(text.encode(), "long.urdf")
