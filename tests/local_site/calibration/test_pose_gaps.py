"""What a set of poses lacks: places, tilts, distances and their number, as sentences; blur as a Gaussian's sigma."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from local_site.calibration.boards import Board, BoardView, edge_blur_px
from local_site.calibration.physical_camera import Lens, PhysicalCamera
from local_site.calibration.pose_gaps import ENOUGH_POSES, aspect_of, empty_places, pose_gaps

BOARD = Board("chessboard", 8, 6, 0.03)
SIZE = (640, 480)
CAMERA = PhysicalCamera(Lens(576.0, 576.0, 320.0, 240.0), np.eye(3), np.zeros(3))
IDS = np.arange(len(BOARD.corners))


def view(x=0.0, y=0.0, z=0.5, about="x", degrees=0.0):
    """The board with its middle there (m), turned about an axis."""
    turn = Rotation.from_euler(about, degrees, degrees=True).as_matrix()
    return BoardView(IDS, CAMERA.pixels((BOARD.corners - BOARD.middle) @ turn.T + (x, y, z)))


def gaps(views):
    return pose_gaps([(one, one) for one in views], BOARD, ("left", "right"), (SIZE, SIZE))


SPREAD = [
    view(about="x", degrees=25),
    view(about="x", degrees=-25),
    view(about="y", degrees=25),
    view(about="y", degrees=-25),
    view(z=0.35),
    *(view(x, y, 0.6) for x in (-0.15, 0.15) for y in (-0.14, 0.14)),
    view(z=0.7),
]


def test_what_is_spread_over_the_picture_tilted_and_near_and_far_is_enough():
    assert gaps(SPREAD) == []


def test_nothing_yet_lacks_everything():
    said = " ".join(gaps([]))
    for words in ("left view: 0 % of its picture", "right view: 0 %", "turn its", "nearer or farther", "10 more poses"):
        assert words in said


@pytest.mark.parametrize(
    ("left_out", "words"),
    [
        (slice(0, 1), "turn its upper edge nearer"),
        (slice(1, 2), "turn its lower edge nearer"),
        (slice(2, 3), "turn its right edge nearer"),
        (slice(3, 4), "turn its left edge nearer"),
        (slice(5, 9), "of its picture covered, needs 40 %: show it at all edges"),
    ],
    ids=str,
)
def test_each_kind_that_is_left_out_is_named_in_both_views(left_out, words):
    rest = [*SPREAD[: left_out.start], *SPREAD[left_out.stop :]]
    rest += [view()] * (ENOUGH_POSES - len(rest))
    said = gaps(rest)
    assert [sentence.partition(":")[0] for sentence in said] == ["left view", "right view"]
    assert all(words in sentence for sentence in said)


def test_one_distance_alone_is_not_enough():
    level = [
        view(x, y, 0.5, about, degrees)
        for x, y in ((-0.2, -0.15), (0.2, 0.15), (-0.2, 0.15), (0.2, -0.15))
        for about, degrees in (("x", 25), ("x", -25), ("y", 25), ("y", -25))
    ]
    assert gaps(level) == [f"{side} view: bring it 30 % nearer or farther away" for side in ("left", "right")]


@pytest.mark.parametrize(("about", "degrees", "tilts"), [("x", 30, (0, -30)), ("x", -20, (0, 20)), ("y", 30, (30, 0))])
def test_tilts_and_distance_are_found_with_the_guessed_focal_length(about, degrees, tilts):
    aspect = aspect_of(view(0.02, -0.01, 0.6, about, degrees), BOARD, SIZE)
    assert (aspect.right_nearer_deg, aspect.lower_nearer_deg) == pytest.approx(tilts, abs=2.5)
    assert aspect.distance == pytest.approx(0.6, rel=0.02)


def test_the_edge_that_is_named_nearer_looks_larger():
    """A board whose right edge is nearer shows that edge longer than its left one."""
    seen = view(about="y", degrees=25)
    grid = seen.pixels.reshape(BOARD.rows - 1, BOARD.columns - 1, 2)
    left, right = (float(np.linalg.norm(grid[-1, k] - grid[0, k])) for k in (0, -1))
    assert (right > left) == (aspect_of(seen, BOARD, SIZE).right_nearer_deg > 0)


def test_places_are_named_as_they_are_in_the_picture():
    pixels = np.array([(u, v) for u in (100, 320, 600) for v in (80, 240, 400) if (u, v) != (600, 80)], dtype=float)
    assert empty_places(pixels, SIZE) == ["the upper right"]


@pytest.mark.parametrize("sigma", [0.8, 1.5, 2.5])
def test_the_blur_of_edges_is_measured(sigma):
    squares = np.kron(np.indices((6, 8)).sum(axis=0) % 2, np.ones((40, 40))) * 180 + 30
    blurred = cv2.GaussianBlur(squares, (0, 0), sigma).astype(np.uint8)
    corners = np.array([(40.0 * x - 0.5, 40.0 * y - 0.5) for x in range(1, 8) for y in range(1, 6)])
    assert edge_blur_px(blurred, corners) == pytest.approx(sigma, rel=0.3)


def test_corners_at_the_border_alone_give_no_sharpness():
    assert edge_blur_px(np.zeros((40, 40), np.uint8), np.array([[2.0, 2.0]])) == np.inf
