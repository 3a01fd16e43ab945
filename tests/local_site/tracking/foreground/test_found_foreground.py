"""The arm in an ordinary room: found whole, alone, with a sharp edge, or refused with the reason."""

from collections.abc import Callable, Sequence

import cv2
import numpy as np
import pytest

from common.cameras.camera import Image
from local_site.kernels.pictures import as_grey
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.foreground.arm_colour import is_grey
from local_site.tracking.foreground.found_foreground import FoundArm, FoundForeground
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.silhouette.hand_view import _refined
from tests.local_site.tracking.foreground.drawn_arm import SKIN, DrawnArm, noisy, overlap, rig, shelf_room

RIG = rig()
PAIRS = 6


def follow(
    foreground: FoundForeground, arm: DrawnArm, rooms: Sequence[Image], change: Callable[[Image], Image] = np.copy
) -> FoundArm:
    """The arm after some pairs of pictures, each with a noise of its own and changed."""
    random = np.random.default_rng(1)
    drawn = [arm.draw(room, matrix)[0] for room, matrix in zip(rooms, RIG.matrices, strict=True)]
    for _ in range(PAIRS):
        found = foreground.find([change(noisy(picture, random)) for picture in drawn], arm.seen(RIG))
    return found


def grey_camera(picture: Image) -> Image:
    """What a grey camera gives, as OpenCV decodes its JPEG."""
    coded = cv2.imencode(".jpg", as_grey(picture))[1]
    return np.asarray(cv2.imdecode(coded, cv2.IMREAD_COLOR), np.uint8)


def overlaps(found: FoundArm, arm: DrawnArm, rooms: Sequence[Image]) -> list[float]:
    """Intersection over union in both views; a refused silhouette fails the test."""
    result = []
    for silhouette, room, matrix in zip(found.silhouettes, rooms, RIG.matrices, strict=True):
        assert isinstance(silhouette, Silhouette), silhouette
        result.append(overlap(silhouette.contour, arm.draw(room, matrix)[1]))
    return result


@pytest.mark.slow
@pytest.mark.parametrize("skin", [(150.0, 180.0, 225.0), SKIN, (45.0, 65.0, 100.0)])
def test_the_whole_bare_arm_is_found_in_every_tone(skin: tuple[float, float, float]) -> None:
    arm, rooms = DrawnArm(skin=skin), (shelf_room(1), shelf_room(2))
    found = follow(FoundForeground(RIG), arm, rooms)
    assert min(overlaps(found, arm, rooms)) > 0.93
    assert np.linalg.norm(found.tubes.forearm.end - arm.elbow) < 0.06


def test_the_outline_is_right_within_half_a_pixel() -> None:
    arm, rooms = DrawnArm(), (shelf_room(1), shelf_room(2))
    found = follow(FoundForeground(RIG), arm, rooms)
    for silhouette, room, matrix in zip(found.silhouettes, rooms, RIG.matrices, strict=True):
        assert isinstance(silhouette, Silhouette)
        truth = arm.draw(room, matrix)[1]
        outside = cv2.distanceTransform(1 - truth, cv2.DIST_L2, 5) - cv2.distanceTransform(truth, cv2.DIST_L2, 5)
        x, y = np.rint(_refined(silhouette.grey, silhouette.contour)).astype(int).T
        assert np.median(np.abs(outside[y.clip(0, 479), x.clip(0, 639)])) <= 1.0  # a mask's border has no 0


@pytest.mark.slow
def test_something_of_skins_colour_that_was_there_before_is_not_the_arm() -> None:
    arm = DrawnArm()
    rooms = [shelf_room(1), shelf_room(2)]
    for room, matrix in zip(rooms, RIG.matrices, strict=True):
        truth = arm.draw(room, matrix)[1]
        x, y, w, h = cv2.boundingRect(truth)
        middle = y + round(0.6 * h)
        cv2.rectangle(room, (x - 80, middle), (x + w + 80, middle + 24), (80.0, 120.0, 175.0), cv2.FILLED)
    random = np.random.default_rng(3)
    foreground = FoundForeground(RIG)
    for _ in range(15):
        foreground.learn_room([noisy(room, random) for room in rooms])
    with_room = overlaps(follow(foreground, arm, rooms), arm, rooms)
    assert min(with_room) > 0.85


def test_another_arm_that_does_not_touch_the_operators_is_left_out() -> None:
    arm, other = DrawnArm(), DrawnArm(shift=(0.0, 0.0, 0.4))
    rooms = [other.draw(room, m)[0] for room, m in zip((shelf_room(1), shelf_room(2)), RIG.matrices, strict=True)]
    assert min(overlaps(follow(FoundForeground(RIG), arm, rooms), arm, rooms)) > 0.9


def test_a_band_on_the_wrist_does_not_cut_the_forearm_off() -> None:
    arm, rooms = DrawnArm(band=True), (shelf_room(1), shelf_room(2))
    assert min(overlaps(follow(FoundForeground(RIG), arm, rooms), arm, rooms)) > 0.88


def test_a_long_sleeve_is_named_with_its_cure() -> None:
    arm, rooms = DrawnArm(long_sleeve=True), (shelf_room(1), shelf_room(2))
    found = follow(FoundForeground(RIG), arm, rooms)
    assert found.silhouettes == (ForegroundReason.COVERED,) * 2
    assert "sleeve" in ForegroundReason.COVERED


def test_a_grey_picture_is_named_as_such_and_not_as_a_sleeve() -> None:
    arm, rooms = DrawnArm(long_sleeve=True), (shelf_room(1), shelf_room(2))
    found = follow(FoundForeground(RIG), arm, rooms, grey_camera)
    assert found.silhouettes == (ForegroundReason.NO_COLOUR,) * 2
    assert "cameras that give colour" in ForegroundReason.NO_COLOUR


def test_pale_skin_in_dim_light_is_not_grey() -> None:
    arm, random = DrawnArm(skin=(58.0, 64.0, 72.0)), np.random.default_rng(1)
    wall = np.full((480, 640, 3), 40, np.uint8)
    picture = noisy(arm.draw(wall, RIG.matrices[0])[0], random)
    assert not is_grey(picture)
    assert is_grey(grey_camera(picture))


def test_a_room_of_the_arms_own_colour_is_refused() -> None:
    rooms = (np.full((480, 640, 3), SKIN, np.uint8),) * 2
    found = follow(FoundForeground(RIG), DrawnArm(), rooms)
    assert not any(isinstance(silhouette, Silhouette) for silhouette in found.silhouettes)


def test_a_hand_outside_the_picture_is_refused() -> None:
    arm, rooms = DrawnArm(shift=(0.0, 0.0, 3.0)), (shelf_room(1), shelf_room(2))
    found = follow(FoundForeground(RIG), arm, rooms)
    assert all(isinstance(silhouette, ForegroundReason) for silhouette in found.silhouettes)


def test_the_arm_is_found_again_elsewhere_after_a_loss() -> None:
    foreground, rooms = FoundForeground(RIG), (shelf_room(1), shelf_room(2))
    follow(foreground, DrawnArm(), rooms)
    foreground.forget()
    moved = DrawnArm(shift=(0.1, 0.0, -0.1))
    assert min(overlaps(follow(foreground, moved, rooms), moved, rooms)) > 0.93


def test_equal_pictures_give_equal_silhouettes() -> None:
    arm, rooms = DrawnArm(), (shelf_room(1), shelf_room(2))
    one, other = (follow(FoundForeground(RIG), arm, rooms).silhouettes[0] for _ in range(2))
    assert isinstance(one, Silhouette)
    assert isinstance(other, Silhouette)
    np.testing.assert_array_equal(one.grey, other.grey)
