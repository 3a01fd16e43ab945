"""The hand's outline to a fraction of a pixel: it lies on the true edge, also where the skin is in shadow."""

import numpy as np
import pytest

from local_site.tracking.features.features import Features
from local_site.tracking.features.medial import MedialLine
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import find_silhouette, to_grey
from local_site.tracking.silhouette.hand_view import MIN_PIXELS, PIXELS_WANTED, make_hand_view

WIDTH, HEIGHT, FINE = 160, 120, 8
CENTRE, RADIUS_PX = np.array([78.3, 61.7]), 33.4
BACKGROUND, SKIN, LEVEL = 9.0, 170.0, 33.0
FOCAL_PX, DISTANCE_M = 800.0, 1.6
CAMERA = np.array([[FOCAL_PX, 0.0, 80.0, 0.0], [0.0, FOCAL_PX, 60.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
WRIST = np.array([0.0, 0.0, DISTANCE_M])
EDGE_PX = 0.15
LINE = MedialLine(np.zeros(2), np.array([1.0, 0.0]))
UNSEEN = np.full((2, 2), np.nan)


def disc(shadow):
    """A disc (H, W) that is `shadow` as bright at its right side as at its left."""
    y, x = (np.arange(n * FINE) / FINE - 0.5 + 0.5 / FINE for n in (HEIGHT, WIDTH))
    inside = np.hypot(x[None, :] - CENTRE[0], y[:, None] - CENTRE[1]) < RADIUS_PX
    share = np.clip((x - CENTRE[0] + RADIUS_PX) / (2 * RADIUS_PX), 0, 1)
    skin = BACKGROUND + (SKIN - BACKGROUND) * (1 - (1 - shadow) * share)
    fine = np.where(inside, skin[None, :], BACKGROUND)
    coarse = fine.reshape(HEIGHT, FINE, WIDTH, FINE).mean(axis=(1, 3))
    noise = np.random.default_rng(3).normal(0.0, 1.0, coarse.shape)
    return np.clip(np.rint(coarse + noise), 0, 255).astype(np.uint8)


def view_of(image, hand=slice(None), shift=(0.0, 0.0)):
    silhouette = find_silhouette(to_grey(image), LEVEL)
    assert silhouette is not None
    return Features(
        forearm=LINE,
        root=LINE,
        forearm_sides=UNSEEN,
        upper_arm=None,
        upper_arm_sides=UNSEEN,
        wrist=None,
        hand=silhouette.contour[hand],
        half_width=20.0,
        silhouette=silhouette,
        guess=Posture(CENTRE, CENTRE, CENTRE, CENTRE, 20.0),
        hand_shift=np.array(shift),
    )


@pytest.mark.parametrize("shadow", [1.0, 0.6, 0.4])
def test_the_outline_lies_on_the_true_edge(shadow):
    view = view_of(disc(shadow))
    hand = make_hand_view(CAMERA, view, WRIST)
    assert hand is not None
    off = np.linalg.norm(hand.pixels - CENTRE, axis=1) - RADIUS_PX
    assert abs(off.mean()) < EDGE_PX
    for side in (hand.pixels[:, 0] < CENTRE[0], hand.pixels[:, 0] > CENTRE[0]):
        assert abs(off[side].mean()) < EDGE_PX
    assert np.abs(off).max() < 3 * EDGE_PX
    rough = np.linalg.norm(view.hand - CENTRE, axis=1) - RADIUS_PX
    assert np.abs(rough).mean() > 2 * np.abs(off).mean()


def test_it_has_about_as_many_pixels_as_wanted():
    hand = make_hand_view(CAMERA, view_of(disc(1.0)), WRIST)
    assert hand is not None
    assert 0.6 * PIXELS_WANTED < len(hand.pixels) < 1.5 * PIXELS_WANTED


def test_the_distance_field_is_positive_inside_and_falls_outside():
    hand = make_hand_view(CAMERA, view_of(disc(1.0)), WRIST)
    assert hand is not None
    x, y = np.rint(CENTRE - hand.origin).astype(int)
    assert hand.field[y, x] == pytest.approx(RADIUS_PX, abs=2.0)
    assert hand.field[y, x + round(RADIUS_PX) + 8] == pytest.approx(-8.0, abs=2.0)


def test_a_nearer_hand_may_differ_by_more_pixels():
    near, far = (make_hand_view(CAMERA, view_of(disc(1.0)), np.array([0.0, 0.0, z])) for z in (0.8, 2.4))
    assert near is not None
    assert far is not None
    assert near.sigma > far.sigma


def test_a_hand_between_two_exposures_is_moved_as_a_whole():
    shift = np.array([2.5, -1.0])
    still, moved = (make_hand_view(CAMERA, view_of(disc(1.0), shift=s), WRIST) for s in ((0.0, 0.0), shift))
    assert still is not None
    assert moved is not None
    np.testing.assert_allclose(moved.pixels - still.pixels, np.broadcast_to(shift, still.pixels.shape), atol=1e-12)
    np.testing.assert_allclose(moved.origin - still.origin, shift)


def test_too_little_of_a_hand_is_none():
    assert make_hand_view(CAMERA, view_of(disc(1.0), slice(0, MIN_PIXELS - 1)), WRIST) is None


def test_a_hand_at_the_pictures_rim_keeps_its_outline():
    image = np.ascontiguousarray(disc(1.0)[: round(CENTRE[1])])
    hand = make_hand_view(CAMERA, view_of(image), WRIST)
    assert hand is not None
    assert np.isfinite(hand.pixels).all()
    assert np.isfinite(hand.field).all()
