"""Block, target and gripper are found in the decoded views where the simulation has them."""

import dataclasses

import cv2
import numpy as np
import pytest

from common.geometry import transform, vector_from_rotation
from lab.visual_operator.sight.sight import Sight
from lab.visual_operator.task import PlacingTask
from tests.lab.visual_operator.page import config, page_of

TASK = PlacingTask()
STARTS = [(0.53, 0.04, 0.0), (0.47, 0.07, -25.0), (0.58, 0.0, 28.0)]


@pytest.fixture(scope="module", params=STARTS, ids=str)
def seen(request):
    site, shown = page_of(config(*request.param))
    return site, shown, Sight(TASK).see(shown)


def apart(pose, true):
    off_mm = 1e3 * np.linalg.norm(pose[:3, 3] - true[:3, 3])
    return off_mm, np.degrees(np.linalg.norm(vector_from_rotation(pose[:3, :3] @ true[:3, :3].T)))


def body_pose(site, name):
    body = site.robot.cell.data.body(name)
    return transform(body.xmat.reshape(3, 3), body.xpos)


def test_the_block_is_found_to_3_mm_and_a_degree(seen):
    site, _, scene = seen
    off_mm, off_deg = apart(scene.block, body_pose(site, "block"))
    assert off_mm < 3.0
    assert off_deg < 1.2


def test_the_target_is_found_to_2_mm_and_a_degree(seen):
    _site, _, scene = seen
    target = np.eye(4)
    target[:2, 3], target[2, 3] = config().simulation.scene.target_corner_xy_m, TASK.table_z
    off_mm, off_deg = apart(scene.target, target)
    assert off_mm < 2.0
    assert off_deg < 1.2


def test_the_gripper_is_found_to_5_mm_and_5_degrees_where_its_own_view_hardly_shows_the_block(seen):
    site, _, scene = seen
    left, right = (site.robot.cell.data.geom(name).xpos for name in ("finger_left", "finger_right"))
    fingers = transform(body_pose(site, "gripper_body")[:3, :3], (left + right) / 2)
    off_mm, off_deg = apart(scene.gripper, fingers)
    assert off_mm < 5.0
    assert off_deg < 5.0


def test_a_gripper_once_taken_for_one_that_points_back_is_found_right_again(seen):
    _site, shown, scene = seen
    sight = Sight(TASK)
    sight.see(shown)
    sight._gripper = transform(scene.gripper[:3, :3] @ np.diag([1.0, -1.0, -1.0]), scene.gripper[:3, 3])
    off_mm, off_deg = apart(sight.see(shown).gripper, scene.gripper)
    assert off_mm < 3.0
    assert off_deg < 10.0


def test_nothing_is_found_where_the_views_are_dark(seen):
    _, shown, _ = seen
    views = {name: dataclasses.replace(v, picture=np.zeros_like(v.picture)) for name, v in shown.views.items()}
    scene = Sight(TASK).see(dataclasses.replace(shown, views=views))
    assert (scene.block, scene.gripper, scene.target) == (None, None, None)


def test_one_view_alone_is_not_enough(seen):
    _, shown, _ = seen
    scene = Sight(TASK).see(dataclasses.replace(shown, views={"side": shown.views["side"]}))
    assert scene.block is None
    assert scene.gripper is None


def coarse(view):
    """The same view as a narrow link shows it at first: a fifth of the size, enlarged again."""
    height, width = view.picture.shape[:2]
    small = cv2.resize(view.picture, (width // 5, height // 5), interpolation=cv2.INTER_AREA)
    return dataclasses.replace(view, picture=cv2.resize(small, (width, height), interpolation=cv2.INTER_LINEAR))


def test_a_target_first_seen_in_coarse_pictures_is_where_the_later_ones_show_it(seen):
    _, shown, scene = seen
    blurred = dataclasses.replace(shown, views={name: coarse(view) for name, view in shown.views.items()})
    sight = Sight(TASK)
    at_first = sight.see(blurred).target
    later = [sight.see(shown).target for _ in range(2)][-1]
    if at_first is not None:
        assert apart(at_first, scene.target)[0] > 0.1
    off_mm, off_deg = apart(later, scene.target)
    assert off_mm < 0.01
    assert off_deg < 0.01
