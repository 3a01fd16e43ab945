"""The four views show the arm and the block as they are at the snapshot's time."""

import sys

import cv2
import mujoco
import numpy as np
import pytest

from common.errors import CameraError
from common.geometry import Array
from remote_site.kinematics.config import RobotConfig
from remote_site.shared_record import SharedRecord
from remote_site.simulation.cell import Cell, build_cell
from remote_site.simulation.config import CellConfig
from remote_site.simulation.memory import snapshot_dtype
from remote_site.simulation.views import simulated_calibration
from remote_site.video.cell_cameras import CellRenderer, open_cell_cameras
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg
from tests.present import present

VIDEO = VideoConfig(width=320, height=240)
VIEWS = ["front_high", "front_low", "side", "gripper"]


@pytest.fixture(scope="module")
def cell():
    return build_cell(CellConfig(), RobotConfig(), dressed=True)


@pytest.fixture(scope="module")
def renderer(cell):
    try:
        renderer = CellRenderer(cell, 320, 240)
    except CameraError as error:
        pytest.skip(str(error))
    yield renderer
    renderer.close()


def posture(cell: Cell, joint_2: float = 0.0) -> Array:
    data = cell.start()
    data.qpos[1] += joint_2
    return np.array(data.qpos)


@pytest.mark.slow
@pytest.mark.parametrize("name", VIEWS)
def test_every_view_sees_the_fingers_and_the_block(cell, renderer, name):
    image = renderer.render(renderer.view_id(name), posture(cell, -0.1)).astype(int)
    blue, green, red = image[:, :, 0], image[:, :, 1], image[:, :, 2]
    orange = (red > 100) & (red - blue > 80) & (green - blue > 25)
    foam = (blue > 70) & (blue - red > 40)
    assert orange.sum() > 15, "fingers"
    assert foam.sum() > 150, "block"


@pytest.mark.parametrize("name", VIEWS)
def test_every_view_shows_the_arm_move(cell, renderer, name):
    view = renderer.view_id(name)
    before = renderer.render(view, posture(cell)).astype(int)
    after = renderer.render(view, posture(cell, 0.3)).astype(int)
    assert (np.abs(before - after).max(axis=2) > 30).mean() > 0.005


@pytest.mark.parametrize("name", VIEWS)
def test_no_view_looks_into_the_dark(cell, renderer, name):
    image = renderer.render(renderer.view_id(name), posture(cell))
    assert (image.max(axis=2) < 10).mean() < 0.01


def test_the_block_in_front_is_below_the_gripper_in_the_picture(cell, renderer):
    image = renderer.render(renderer.view_id("side"), posture(cell)).astype(int)
    foam = np.argwhere((image[:, :, 0] > 70) & (image[:, :, 0] - image[:, :, 2] > 40))
    fingers = np.argwhere((image[:, :, 2] > 100) & (image[:, :, 2] - image[:, :, 0] > 80) & (image[:, :, 1] > 80))
    assert fingers[:, 0].mean() < foam[:, 0].min()


@pytest.mark.parametrize("view", CellConfig().views, ids=lambda view: view.name)
def test_a_calibrated_view_shows_the_block_where_it_projects_it(cell, renderer, view):
    qpos = posture(cell, -0.1)
    image = renderer.render(renderer.view_id(view.name), qpos).astype(int)
    foam = (image[:, :, 0] > 70) & (image[:, :, 0] - image[:, :, 2] > 40)
    told = simulated_calibration(view, 320, 240)
    data = cell.start()
    data.qpos[:] = qpos
    mujoco.mj_kinematics(cell.model, data)
    point = data.body("block").xpos
    if told.on_tool:
        tool = data.body("tool0")
        point = tool.xmat.reshape(3, 3).T @ (point - tool.xpos)
    u, v, w = np.reshape(told.projection, (3, 4)) @ [*point, 1.0]
    assert w > 0
    rows, columns = np.nonzero(foam)
    inside = (abs(columns - u / w) < 4) & (abs(rows - v / w) < 4)
    assert inside.sum() > 20, "the block's middle"


@pytest.mark.parametrize("name", VIEWS[:3])
def test_a_kept_background_shows_what_drawing_it_anew_shows(cell, renderer, name):
    view = renderer.view_id(name)
    for joint_2 in (0.2, -0.4):
        kept = renderer.render(view, posture(cell, joint_2)).astype(int)
        anew = renderer._drawn_anew(view).astype(int)
        apart = cv2.blur(np.abs(kept - anew).max(axis=2).astype(np.float32), (5, 5))
        assert (apart > 60).mean() < 0.002, "a thing is drawn where it is hidden, or not drawn"


@pytest.mark.parametrize("name", VIEWS[:3])
def test_what_is_drawn_anew_around_what_moves_is_all_that_has_moved(cell, renderer, name, monkeypatch):
    view, chance = renderer.view_id(name), np.random.default_rng(1)
    postures = [posture(cell) for _ in range(6)]
    for qpos in postures:
        qpos[cell.arm] += chance.uniform(-1.5, 1.5, len(cell.joints))
        qpos[-7:-4] += chance.uniform(-0.3, 0.3, 3)  # the block
    around = [renderer.render(view, qpos).astype(int) for qpos in postures]
    monkeypatch.setattr(renderer, "_where_things_move", lambda _view: renderer._whole)
    for picture, qpos in zip(around, postures, strict=True):
        apart = np.abs(picture - renderer.render(view, qpos).astype(int)).max(axis=2) > 8
        assert apart.sum() < 20, "pixels at edges alone, which are drawn from another corner"


@pytest.mark.usefixtures("renderer")
def test_what_has_not_moved_is_not_drawn_again(cell, monkeypatch):
    record, drawn = SharedRecord(snapshot_dtype(6)), []
    camera = open_cell_cameras(["side"], cell, record, VIDEO)[0]

    def render(view, _qpos):
        drawn.append(view)
        return np.zeros((9, 9, 3), np.uint8)

    monkeypatch.setattr(camera._renderer, "render", render)
    snapshot = np.zeros((), record.dtype)
    for k, turned in enumerate((0.0, 1e-6, 1e-3, 1e-3)):
        snapshot[()] = (1_000_000 * (k + 1), posture(cell, turned))
        record.write(snapshot)
        assert present(camera.newest()).capture_ns == 1_000_000 * (k + 1)
    camera.close()
    assert len(drawn) == 2


@pytest.mark.parametrize("name", VIEWS[:3])
def test_a_picture_is_as_hard_to_compress_as_one_of_a_real_cell(cell, name):
    renderer = CellRenderer(cell, 640, 480)
    picture = renderer.render(renderer.view_id(name), posture(cell))
    renderer.close()
    assert len(encode_jpeg(picture, 80)) > 40_000


@pytest.mark.usefixtures("renderer")
def test_a_frame_bears_the_time_of_the_posture_and_comes_once(cell):
    record = SharedRecord(snapshot_dtype(6))
    cameras = open_cell_cameras(["side"], cell, record, VIDEO)
    assert cameras[0].newest() is None
    snapshot = np.zeros((), record.dtype)
    snapshot[()] = (123_456_789, posture(cell))
    record.write(snapshot)
    first, again = present(cameras[0].newest()), cameras[0].newest()
    assert first is again
    assert (first.capture_ns, first.seq, first.capture_estimated) == (123_456_789, 0, False)
    snapshot["t_ns"] += 33_000_000
    record.write(snapshot)
    assert present(cameras[0].newest()).seq == 1
    cameras[0].close()
    cameras[0].close()


def test_an_unknown_view_is_named_with_the_known(renderer):
    with pytest.raises(CameraError, match=r"roof.*front_high, front_low, side, gripper"):
        renderer.view_id("roof")


def test_without_egl_the_cure_is_named(cell, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    with pytest.raises(CameraError, match="apt-get install libegl1"):
        CellRenderer(cell, 320, 240)
