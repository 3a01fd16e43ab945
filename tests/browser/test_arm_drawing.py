"""The arm in 3D: what is painted over what, arcs and words of joints near a limit, fingers, shadows, what is seen."""

import base64
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import cv2
import msgspec
import numpy as np
import pinocchio as pin
import pytest

from common.geometry import Array
from common.messages.robot import GripperCommand, GripperState, GripperStatus, RobotState, SessionState
from lab.measure.page import scene
from local_site.console.hub import Hub
from tests.browser.told import Told
from tests.present import present

CELL = scene.cell()
LIMITS = [(joint.lower, joint.upper) for joint in CELL.joints]
SIZE = "([w, h]) => document.getElementById('arm').style.cssText = `flex: none; width: ${w}px; height: ${h}px`"
DRAWN_MS = 250  # the arm is drawn again every 100 ms
BLOCK = {"lower": [0.0, 0.0, 0.0], "upper": [1.0, 1.0, 0.5]}
SLIDE = {"name": "rail", "lower": 0.0, "upper": 2.0, "slides": True}


def computed(told: Told, module: str, call: str, *values: object) -> Any:
    """What a function of one of the page's modules gives; `call` uses `m`, the module, and `v`, the values."""
    plain = msgspec.to_builtins(values)
    return told.page.page.evaluate(
        f"async (v) => {{ const m = await import('/static/{module}.js'); return {call}; }}", plain
    )


def capsule(*ends: tuple[float, float, float]) -> dict[str, object]:
    return {"start": ends[0], "end": ends[-1], "radius": 0.05}


def engaged(q: Array, **changes: object) -> Callable[..., RobotState | None]:
    """A state with the arm at rest in a posture (rad)."""
    posture = tuple(np.asarray(q, float).tolist())
    changes = {"q": posture, "q_commanded": posture, "target": None} | changes
    return partial(scene.state, SessionState.ENGAGED, "ok", "the arm follows the hand", **changes)


def near(joint: int, degrees: float) -> Array:
    """The start posture with one joint short of its upper limit."""
    q = scene.CONFIG.robot.start.copy()
    q[joint] = LIMITS[joint][1] - np.radians(degrees)
    return q


@pytest.mark.parametrize(
    ("point", "behind"),
    [
        ((0.5, 0.5, 0.7), False),  # stands over it, seen from above
        ((0.5, -0.5, 0.2), False),  # between the eye and it
        ((0.5, 1.5, 0.2), True),
        ((-0.5, 0.5, 0.2), True),
        ((0.5, 0.5, -0.2), True),  # below it
        ((0.5, 0.5, 0.2), None),  # within it
    ],
)
def test_a_capsule_is_behind_a_box_where_a_face_that_the_eye_does_not_see_separates_them(
    told: Told, point: tuple[float, float, float], behind: bool | None
) -> None:
    eye = [2.0, -3.0, 2.0]
    assert computed(told, "depth_order", "m.isBehindBox(...v)", capsule(point), BLOCK, eye) is behind


def test_what_is_farther_is_painted_first_except_where_a_box_says_otherwise(told: Told) -> None:
    sight = {"position": [0.5, -3.0, 1.5], "toward": [0.0, -1.0, 0.0]}
    on_top, before, behind = (capsule((0.5, y, z)) for y, z in ((0.9, 0.6), (-0.3, 0.2), (1.3, 0.2)))
    order = computed(told, "depth_order", "m.ordered(v[0], v[1], v[2])", [before, on_top, behind], [BLOCK], sight)
    painted = ["box" if "box" in item else item["capsule"]["start"][1] for item in order]
    assert painted == [1.3, "box", 0.9, -0.3]


def test_what_is_inside_of_others_is_painted_before_them_however_near_it_is(told: Told) -> None:
    sight = {"position": [0.5, -3.0, 1.5], "toward": [0.0, -1.0, 0.0]}
    near_by = capsule((0.5, -1.0, 0.2)) | {"inner": True}
    order = computed(told, "depth_order", "m.ordered(v[0], [], v[1])", [capsule((0.5, 1.0, 0.2)), near_by], sight)
    assert [item["capsule"]["start"][1] for item in order] == [-1.0, 1.0]


def test_items_that_each_have_to_precede_another_are_all_painted_once(told: Told) -> None:
    circle = "m.paintOrder([1, 3, 2], (a, b) => (a + 1) % 3 === b)"
    assert computed(told, "depth_order", circle) == [1, 2, 0]


@pytest.mark.parametrize(
    ("degrees", "found"), [(20.0, None), (15.5, None), (14.5, False), (4.5, False), (3.5, True), (-1.0, True)]
)
@pytest.mark.parametrize("upward", [True, False])
def test_a_joint_is_near_its_limit_from_15_degrees_on_and_at_it_from_4(
    told: Told, degrees: float, found: bool | None, upward: bool
) -> None:
    q = scene.CONFIG.robot.start.copy()
    lower, upper = LIMITS[2]
    q[2] = upper - np.radians(degrees) if upward else lower + np.radians(degrees)
    limits = computed(told, "joint_limits", "m.nearLimits(v[0], v[1])", CELL, q.tolist())
    assert [(limit["joint"], limit["at"]) for limit in limits] == ([] if found is None else [(2, found)])
    if limits:
        assert limits[0]["way"] == pytest.approx(np.radians(max(degrees, 0.0)) * (1 if upward else -1))


@pytest.mark.parametrize(
    ("at_m", "words"), [(1.0, ""), (1.6, ""), (1.75, "rail 250 mm from its limit"), (0.02, "rail 20 mm from its limit")]
)
def test_a_joint_that_slides_is_near_by_a_share_of_its_range(told: Told, at_m: float, words: str) -> None:
    assert computed(told, "joint_limits", "m.limitWords(v[0], v[1])", {"joints": [SLIDE]}, [at_m]) == words
    (limit, *_) = computed(told, "joint_limits", "m.nearLimits(v[0], v[1])", {"joints": [SLIDE]}, [at_m]) or [None]
    assert limit is None or limit["at"] == (at_m == 0.02)


@pytest.mark.parametrize("joint", [0, 2, 4])
def test_an_arc_ends_where_the_tool_will_be_when_the_joint_has_reached_its_limit(told: Told, joint: int) -> None:
    q = near(joint, 12.0)
    found = computed(told, "kinematics", "m.frames(v[0], v[1])", CELL, q.tolist())
    tool = scene.MODEL.position(q).tolist()
    arced = "m.arc(m.turning(v[0], v[1], v[2]), v[3], 0.2)"
    points = np.array(
        computed(told, "limit_arcs", arced, CELL.joints[joint], found[joint + 1], tool, float(np.radians(12.0)))
    )
    frame = np.reshape(found[joint + 1], (4, 4))
    axis, at = frame[:3, :3] @ CELL.joints[joint].axis, frame[:3, 3]
    for point, posture in ((points[0], q), (points[-1], near(joint, 0.0))):
        to_tool = scene.MODEL.position(posture) - at
        to_tool -= axis * (axis @ to_tool)
        assert (point - at) / 0.2 == pytest.approx(to_tool / np.linalg.norm(to_tool), abs=1e-4)


def test_the_arc_of_a_joint_that_only_turns_the_tool_begins_beside_its_axis(told: Told) -> None:
    found = computed(told, "kinematics", "m.frames(v[0], v[1])", CELL, scene.CONFIG.robot.start.tolist())
    tool = [found[-1][3], found[-1][7], found[-1][11]]
    plane = computed(told, "limit_arcs", "m.turning(v[0], v[1], v[2])", CELL.joints[5], found[6], tool)
    assert np.dot(plane["axis"], plane["toward"]) == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.norm(plane["toward"]) == pytest.approx(1.0)


def test_capsules_are_drawn_where_the_links_are(told: Told) -> None:
    q = np.array([0.3, -0.4, -0.9, 0.5, -0.7, 0.2])
    call = "m.placedCapsules(v[0], (await import('/static/kinematics.js')).frames(v[0], v[1]))"
    drawn = computed(told, "arm_solids", call, CELL, q.tolist())
    data = scene.MODEL.pin_model.createData()
    pin.framesForwardKinematics(scene.MODEL.pin_model, data, q)
    frames = [*data.oMi, data.oMf[scene.MODEL.tcp_frame]]
    for solid, described in zip(drawn, CELL.shapes.capsules, strict=True):
        frame = frames[described.link]
        assert solid["start"] == pytest.approx(frame.act(np.array(described.start)), abs=1e-6)
        assert solid["end"] == pytest.approx(frame.act(np.array(described.end)), abs=1e-6)
        assert solid["tool"] == (described.link == len(CELL.joints) + 1)


@pytest.mark.parametrize("opening", [0.0, 0.02, 0.065])
def test_the_fingers_are_as_far_apart_as_measured(told: Told, opening: float) -> None:
    call = "m.gripperSolids(v[0], (await import('/static/kinematics.js')).frames(v[0], v[1]), { opening: v[2] })"
    solids = computed(told, "arm_solids", call, CELL, scene.CONFIG.robot.start.tolist(), opening)
    one, other = (solid for solid in solids if solid.get("finger"))
    apart = np.linalg.norm(np.subtract(one["end"], other["end"])) - one["radius"] - other["radius"]
    assert apart == pytest.approx(opening, abs=1e-6)


def test_a_surface_is_brightest_where_it_faces_the_light_and_dark_where_it_does_not(told: Told) -> None:
    upright = [0.0, 1.0, 0.0]
    left, middle, right = (
        computed(told, "capsule_shading", "m.lambert(v[0], v[1])", upright, t) for t in (0.6, 0, -0.6)
    )
    assert left > middle > right
    tones = [
        computed(told, "capsule_shading", "m.shaded([118, 187, 255], v[0])", term) for term in (0.0, 0.4, 0.72, 1.0)
    ]
    assert [sum(tone) for tone in tones] == sorted(sum(tone) for tone in tones)
    assert tones[2] == pytest.approx([118, 187, 255])


def test_a_shadow_is_straight_below_and_on_the_highest_top(told: Told) -> None:
    outline = np.array(computed(told, "shadows", "m.shadow(v[0], 0.5)", capsule((0.2, 0.2, 0.9), (0.6, 0.2, 0.7))))
    assert set(outline[:, 2]) == {0.5}
    assert outline.min(axis=0)[:2] == pytest.approx([0.15, 0.15])
    assert outline.max(axis=0)[:2] == pytest.approx([0.65, 0.25])
    lower = {"lower": [0, 0, 0], "upper": [1, 1, 0.1]}
    for point, top in (((0.5, 0.5, 0.9), 0.5), ((0.5, 0.5, 0.3), 0.1), ((2.0, 0.5, 0.9), None)):
        assert computed(told, "shadows", "m.topBelow(v[0], v[1])", point, [lower, BLOCK]) == top


@pytest.mark.parametrize("size", [(300, 220), (560, 420), (220, 500)])
def test_the_base_and_nearly_the_whole_workspace_are_seen_from_the_first_view(
    told: Told, size: tuple[int, int]
) -> None:
    sight = """(() => { const orbit = new m.Orbit(document.createElement('canvas'), () => {});
      orbit.show(v[0].workspace_min, v[0].workspace_max);
      const { project } = orbit.sight(v[1], v[2]); return v[3].map(project); })()"""
    low, high = np.array(CELL.workspace_min), np.array(CELL.workspace_max)
    corners = [low + (high - low) * [0.1 + 0.8 * (k >> axis & 1) for axis in range(3)] for k in range(8)]
    seen = np.array(computed(told, "orbit", sight, CELL, *size, [[0.0, 0.0, 0.0], *(c.tolist() for c in corners)]))
    assert (seen[:, :2] > 0).all()
    assert (seen[:, :2] < size).all()
    filled = np.ptp(seen[:, :2], axis=0) / size
    assert filled.max() > 0.75


PICTURE = "() => document.getElementById('arm').toDataURL().split(',')[1]"


def drawn(told: Told) -> np.ndarray:
    """The canvas's pixels (n, 4): red, green, blue, alpha."""
    png = np.frombuffer(base64.b64decode(told.page.page.evaluate(PICTURE)), np.uint8)
    return present(cv2.imdecode(png, cv2.IMREAD_UNCHANGED))[:, :, [2, 1, 0, 3]].reshape(-1, 4).astype(int)


def close_to(pixels: np.ndarray, hexed: str) -> int:
    """How many opaque pixels are nearly of a colour."""
    colour = [int(hexed[k : k + 2], 16) for k in (1, 3, 5)]
    return int(((np.abs(pixels[:, :3] - colour) < 12).all(axis=1) & (pixels[:, 3] > 200)).sum())


@pytest.fixture
def small(told: Told) -> Iterator[Told]:
    """A small canvas on a dark page, put back afterwards."""
    told.page.wear("dark")
    told.page.page.evaluate(SIZE, [300, 220])
    yield told
    told.page.page.evaluate("() => document.getElementById('arm').removeAttribute('style')")
    told.describe()


@pytest.mark.slow
@pytest.mark.parametrize(("degrees", "tone", "other"), [(10.0, "#f2bd4b", "#ff8a80"), (3.0, "#ff8a80", "#f2bd4b")])
def test_a_joint_near_its_limit_is_named_and_seen_in_its_colour(
    small: Told, degrees: float, tone: str, other: str
) -> None:
    small.state = engaged(near(4, degrees))
    words = f"joint_5 {degrees:.0f}° from its limit"
    small.until("the joint's name", lambda: words in small.page.words("#arm-words"))
    small.until("its colour", lambda: close_to(drawn(small), tone) > 80)
    assert close_to(drawn(small), other) < 5
    small.shot(f"joint {degrees:.0f} deg from its limit")
    small.state = engaged(scene.CONFIG.robot.start)
    small.until("no joint", lambda: "limit" not in small.page.words("#arm-words"))
    small.until("no colour", lambda: close_to(drawn(small), tone) < 5)


def test_several_joints_near_their_limits_are_named_the_nearest_first(small: Told) -> None:
    q = near(4, 3.0)
    q[0] = LIMITS[0][0] + np.radians(11.0)
    small.state = engaged(q)
    words = "joint_5 3°, joint_1 11° from their limits"
    small.until("both names", lambda: small.page.words("#arm-words").startswith(words))


@pytest.mark.slow
def test_an_open_gripper_and_a_closed_one_are_drawn_differently(small: Told) -> None:
    def show(opening_m: float, status: GripperStatus) -> None:
        gripper = GripperState(opening_m, 0.0, GripperCommand(status.value), status)
        small.state = engaged(np.radians([0, -10, -60, 40, -45, 30]), gripper=gripper)
        small.until("the gripper", lambda: close_to(drawn(small), "#e9edf2") > 10)
        small.until("the words", lambda: status.value in small.page.words("#gripper"))
        small.page.page.wait_for_timeout(DRAWN_MS)
        small.shot(f"gripper {status.value}")

    show(0.065, GripperStatus.OPEN)
    wide = drawn(small)
    show(0.0, GripperStatus.CLOSED)
    small.until("another drawing", lambda: (drawn(small) != wide).any(axis=1).sum() > 30)


def test_a_cell_that_sends_no_capsules_is_drawn_as_lines(small: Told) -> None:
    small.state = engaged(scene.CONFIG.robot.start)
    small.until("the arm", lambda: "tool at" in small.page.words("#arm-words"))
    small.page.page.wait_for_timeout(DRAWN_MS)
    solid = (drawn(small)[:, 3] > 200).sum()
    bare = msgspec.structs.replace(CELL, shapes=msgspec.structs.replace(CELL.shapes, capsules=()))
    small.give(Hub.described, bare)
    small.until("lines", lambda: (drawn(small)[:, 3] > 200).sum() < 0.7 * solid)
    small.shot("arm of lines")
    assert close_to(drawn(small), "#76bbff") > 150


def test_a_state_of_another_arm_than_the_one_described_is_not_drawn(small: Told) -> None:
    small.state = engaged(near(4, 10.0))
    small.until("the arm", lambda: close_to(drawn(small), "#f2bd4b") > 80)
    small.give(Hub.described, msgspec.structs.replace(CELL, joints=CELL.joints[:5]))
    small.until("no arm", lambda: close_to(drawn(small), "#f2bd4b") == 0)
    assert (drawn(small)[:, 3] > 0).any()
