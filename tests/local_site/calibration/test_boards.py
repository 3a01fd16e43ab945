"""Printed boards: corners found in rendered pictures, cameras solved from them, and every doubt refused with a cure."""

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from common.errors import CalibrationError, ConfigError
from local_site.calibration.accuracy import align_rigidly
from local_site.calibration.board_rig import BoardPictures, solve_boards
from local_site.calibration.boards import Board, BoardFinder, BoardView
from local_site.calibration.checks import rig_mistakes
from local_site.calibration.physical_camera import Lens, PhysicalCamera
from local_site.calibration.triangulation import triangulate
from local_site.simulation.calibration_scenes.board_scene import SIZE, BoardRenderer
from tests.local_site.calibration.board_scenes import looking_down, poses
from tests.present import present

CHARUCO = Board("charuco", 8, 6, 0.03, 0.022)
CHESS = Board("chessboard", 9, 6, 0.03)
POSES = 7
CAMERAS = ("left", "right")
SCENES = [
    pytest.param(CHARUCO, -0.1, id="charuco through a lens"),
    pytest.param(CHESS, 0.0, id="chessboard"),
    pytest.param(CHESS, -0.1, id="chessboard through a lens", marks=pytest.mark.long),
]


@lru_cache(maxsize=8)
def rendered(board, k1):
    """Both cameras, the poses, and each camera's pictures of them."""
    cameras, placed = [looking_down(side, k1) for side in (-1, 1)], poses(board, POSES)
    renderers = [BoardRenderer(board, camera, seed) for seed, camera in enumerate(cameras)]
    return cameras, placed, [[renderer.picture(*pose) for pose in placed] for renderer in renderers]


@lru_cache(maxsize=8)
def scene(board, k1):
    """Both cameras, the poses, and what the finder sees of them."""
    cameras, placed, pictures_of = rendered(board, k1)
    return cameras, placed, [[BoardFinder(board).find(picture) for picture in own] for own in pictures_of]


def exact_views(board, cameras, placed, noise=0.05):
    """Views without pictures: the exact pixels, and a little noise."""
    random, ids = np.random.default_rng(1), np.arange(len(board.corners))
    return [
        [
            BoardView(ids, c.pixels(board.corners @ R.T + t) + noise * random.standard_normal((len(ids), 2)))
            for R, t in placed
        ]
        for c in cameras
    ]


def pictures(views, names=CAMERAS):
    return BoardPictures(views, (SIZE,) * len(views), names)


def worst_mm(rig, cameras):
    random = np.random.default_rng(1)
    distances = []
    for point in random.uniform((-0.12, -0.12, 0.0), (0.12, 0.12, 0.12), (40, 3)):
        seen = [c.pixels(point) for c in cameras]
        straight = [p if c.lens is None else c.lens.undistort_pixels(p) for c, p in zip(rig.cameras, seen, strict=True)]
        distances.append(np.linalg.norm(triangulate(rig.matrices, straight) - point))
    return 1e3 * max(distances)


@pytest.mark.slow
@pytest.mark.parametrize(("board", "k1"), SCENES)
def test_corners_are_found_to_a_tenth_of_a_pixel(board, k1):
    cameras, placed, views = scene(board, k1)
    for camera, own in zip(cameras, views, strict=True):
        assert sum(view is not None for view in own) >= POSES - 1
        for (R, t), view in zip(placed, own, strict=True):
            if view is not None:
                off = view.pixels - camera.pixels(board.corners[view.ids] @ R.T + t)
                assert np.sqrt(np.mean(off**2)) < 0.1


@pytest.mark.parametrize(("board", "k1"), SCENES)
def test_rendered_boards_give_back_the_cameras_in_the_first_boards_frame(board, k1):
    cameras, _, views = scene(board, k1)
    rig, control = solve_boards(pictures(views), board, "now")
    assert all((c.lens is None) == (k1 == 0.0) for c in rig.cameras)
    assert all(c.reprojection_rms_px < 0.12 for c in rig.cameras)
    assert np.linalg.norm(rig.error_rms) < 0.0003
    assert np.linalg.norm(present(rig.leave_one_out_rms)) >= 0.95 * np.linalg.norm(rig.error_rms)
    assert worst_mm(rig, cameras) < 0.5
    assert rig.cameras[0].size_px == SIZE
    assert len(control.points) > 200


def test_both_numbers_of_a_strong_distortion_are_found():
    cameras = [looking_down(side, -0.25, 0.15) for side in (-1, 1)]
    rig, _ = solve_boards(pictures(exact_views(CHESS, cameras, poses(CHESS, 10), noise=0.02)), CHESS, "now")
    for found in rig.cameras:
        assert (present(found.lens).k1, present(found.lens).k2) == pytest.approx((-0.25, 0.15), abs=0.04)
    assert worst_mm(rig, cameras) < 0.1


def test_three_cameras_are_solved_together():
    cameras = [looking_down(side) for side in (-1, 1, 0)]
    rig, _ = solve_boards(pictures(exact_views(CHESS, cameras, poses(CHESS, 8)), (*CAMERAS, "third")), CHESS, "now")
    assert [c.name for c in rig.cameras] == ["left", "right", "third"]
    assert worst_mm(rig, cameras) < 0.3


def test_a_standing_first_board_gives_an_upright_frame():
    cameras = [looking_down(side) for side in (-1, 1)]
    placed = poses(CHESS, 8)[1:]
    # Upright: the print's x to the right, its down downwards, and into the print away from the cameras.
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    placed = [(upright, -upright @ CHESS.middle), *placed]
    rig, _ = solve_boards(pictures(exact_views(CHESS, cameras, placed)), CHESS, "now", standing=True)
    assert worst_mm(rig, cameras) < 0.3


def test_a_first_board_laid_the_other_way_round_gives_the_same_frame():
    cameras, placed = [looking_down(side) for side in (-1, 1)], poses(CHARUCO, 8)
    round_R = np.diag([-1.0, -1.0, 1.0])
    turned = (round_R @ placed[0][0], -(round_R @ placed[0][0]) @ CHARUCO.middle)
    rig, _ = solve_boards(pictures(exact_views(CHARUCO, cameras, [turned, *placed[1:]])), CHARUCO, "now")
    assert worst_mm(rig, cameras) < 0.3


def facing(side):
    """A camera 0.9 m in front of a board that is held up, on the left (-1) or right (1)."""
    turn = Rotation.from_euler("y", 20 * side, degrees=True).as_matrix()
    return PhysicalCamera(Lens(800.0, 800.0, 320.0, 240.0), turn, np.array([0.0, 0.0, 0.9]))


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [("x", 34), ("x", -34), ("y", 34), ("x", 50)], ids=str)
def test_a_tilted_first_board_before_cameras_that_face_it_is_solved_and_not_taken_for_exchanged_cameras(tilt):
    cameras = [facing(side) for side in (-1, 1)]
    axis, angle_deg = tilt
    first = Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
    random = np.random.default_rng(0)
    turns = [Rotation.from_euler("xyz", random.uniform(-30, 30, 3), degrees=True).as_matrix() for _ in range(8)]
    placed = [(R, random.uniform(-0.08, 0.08, 3) - R @ CHARUCO.middle) for R in turns]
    placed[0] = (first, -first @ CHARUCO.middle)
    views = [
        [BoardFinder(CHARUCO).find(BoardRenderer(CHARUCO, camera, k).picture(*pose)) for pose in placed]
        for k, camera in enumerate(cameras)
    ]
    rig, _ = solve_boards(pictures(views), CHARUCO, "now")
    assert not rig_mistakes(rig)
    centres = [-np.linalg.solve(m[:, :3], m[:, 3]) for m in rig.matrices]
    assert np.linalg.norm(centres[1] - centres[0]) == pytest.approx(2 * 0.9 * np.sin(np.radians(20)), abs=0.003)
    with pytest.raises(CalibrationError, match="exchange the two"):
        solve_boards(pictures(views[::-1]), CHARUCO, "now")


def test_exchanged_cameras_are_refused():
    _, _, views = scene(CHESS, 0.0)
    with pytest.raises(CalibrationError, match="exchange the two"):
        solve_boards(pictures(views[::-1]), CHESS, "now")


def test_one_camera_given_twice_is_refused():
    _, _, views = scene(CHESS, 0.0)
    with pytest.raises(CalibrationError, match="move the cameras apart"):
        solve_boards(pictures([views[0], views[0]]), CHESS, "now")


def test_pictures_in_another_order_are_refused():
    _, _, views = scene(CHESS, 0.0)
    with pytest.raises(CalibrationError, match="same order"):
        solve_boards(pictures([views[0], [*views[1][3:], *views[1][:3]]]), CHESS, "now")


def test_mirrored_pictures_are_told():
    picture = rendered(CHARUCO, -0.1)[2][0][1]
    finder = BoardFinder(CHARUCO)
    mirrored = np.ascontiguousarray(picture[:, ::-1])
    assert finder.find(mirrored) is None
    assert finder.finds_mirrored(mirrored)
    assert not finder.finds_mirrored(picture)


@pytest.mark.slow
def test_one_mirrored_camera_before_a_chessboard_is_refused():
    _, _, (_, right) = rendered(CHESS, 0.0)
    _, _, (views, _) = scene(CHESS, 0.0)
    mirrored = [BoardFinder(CHESS).find(np.ascontiguousarray(picture[:, ::-1])) for picture in right]
    with pytest.raises(CalibrationError, match="switch off the mirroring of both"):
        solve_boards(pictures([views, mirrored]), CHESS, "now")


def test_few_poses_and_parallel_poses_are_refused():
    cameras, placed = [looking_down(side) for side in (-1, 1)], poses(CHESS, 8)
    with pytest.raises(CalibrationError, match="in 4 poses, needs at least 5; show it at more"):
        solve_boards(pictures(exact_views(CHESS, cameras, placed[:4])), CHESS, "now")
    flat = placed[0][0]
    level = [(flat, np.array([0.02 * k, 0.01 * k, 0.01 * k]) - flat @ CHESS.middle) for k in range(-4, 4)]
    with pytest.raises(CalibrationError, match="tilt it by 30 degrees"):
        solve_boards(pictures(exact_views(CHESS, cameras, level)), CHESS, "now")


def test_a_board_that_bends_is_refused():
    cameras, placed = [looking_down(side) for side in (-1, 1)], poses(CHESS, 8)
    views = exact_views(CHESS, cameras, placed)
    warped = [[replace(v, pixels=v.pixels + 6.0 * np.sin(v.pixels[:, ::-1] / 12.0)) for v in own] for own in views]
    with pytest.raises(CalibrationError, match=r"do not fit one rig.*keep the board flat"):
        solve_boards(pictures(warped), CHESS, "now")


@pytest.mark.parametrize("board", [CHARUCO, CHESS], ids=["charuco", "chessboard"])
@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((480, 640), np.uint8),
        np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8),
        np.full((20, 20), 200, np.uint8),
    ],
    ids=["black", "random", "tiny"],
)
def test_pictures_without_a_board_give_none(board, picture):
    assert BoardFinder(board).find(picture) is None


def test_a_chessboard_turned_round_keeps_its_names():
    camera = looking_down(-1)
    flat = np.diag([1.0, -1.0, -1.0])
    round_R = np.diag([-1.0, -1.0, 1.0]) @ flat
    for R in (flat, round_R):
        t = -R @ CHESS.middle
        view = present(BoardFinder(CHESS).find(BoardRenderer(CHESS, camera, 0).picture(R, t)))
        assert view.pixels == pytest.approx(camera.pixels(CHESS.corners @ R.T + t), abs=0.3)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"columns": 2}, "--squares must be 3 to 60"),
        ({"rows": 99}, "--squares must be 3 to 60"),
        ({"marker": 0.03}, "--marker-mm must be larger than 0 and smaller"),
        ({"dictionary": "9X9_1"}, "--dictionary must be one such as"),
    ],
)
def test_impossible_boards_are_refused(numbers, words):
    with pytest.raises(ConfigError, match=words):
        replace(CHARUCO, **numbers)


def test_the_corners_are_opencvs():
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_250)
    printed = cv2.aruco.CharucoBoard((8, 6), 0.03, 0.022, dictionary)
    assert np.asarray(printed.getChessboardCorners()) == pytest.approx(CHARUCO.corners, abs=1e-7)


def test_a_shape_is_aligned_with_its_moved_copy_exactly_and_never_mirrored():
    random = np.random.default_rng(0)
    shape = random.uniform(-1, 1, (9, 3))
    turn = np.linalg.qr(random.standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    assert align_rigidly(shape, shape @ turn.T + 3.0) == pytest.approx(shape @ turn.T + 3.0)
    mirrored = shape * (-1.0, 1.0, 1.0)
    assert np.abs(align_rigidly(shape, mirrored) - mirrored).max() > 0.1
