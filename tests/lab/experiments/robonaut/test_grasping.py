"""The arm that handles a flask: its links keep their lengths, the flask goes with the palm while it is held."""

import numpy as np
import pytest

from lab.experiments.robonaut.grasping import (
    FLASK_HALF_M,
    FLASK_IN_PALM,
    GRASPING,
    HANDLING_FRAMES,
    MOVING,
    TABLE_Y,
    bookshelf,
    grasping_film,
)
from local_site.simulation.hazel import FOREARM_M, PALM_POINT_M, SIZE_PX, UPPER_ARM_M, film_pixel
from local_site.simulation.textured_arm import Scenery

HANDLINGS = pytest.mark.parametrize("handling", [GRASPING, MOVING], ids=["grasping", "moving"])


def palm(arm):
    return arm.along_forearm(FOREARM_M + PALM_POINT_M)


@HANDLINGS
def test_the_arm_begins_parallel_to_the_picture_and_stays_one_arm_in_view(handling):
    first = handling.arm(0)
    assert [link[2, 2] for link in (first.upper_arm, first.forearm)] == pytest.approx([0.0, 0.0], abs=1e-9)
    for k in range(HANDLING_FRAMES):
        arm = handling.arm(k)
        for rotation in (arm.upper_arm, arm.forearm):
            np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
            assert np.linalg.det(rotation) > 0
        assert np.linalg.norm(arm.elbow - arm.shoulder) == pytest.approx(UPPER_ARM_M)
        for point in (arm.shoulder, arm.elbow, palm(arm)):
            assert (np.array(film_pixel(point)) > 20).all()
            assert (np.array(film_pixel(point)) < np.array(SIZE_PX) - 20).all()


@HANDLINGS
def test_the_palm_rests_where_it_stops_and_moves_smoothly_in_between(handling):
    for frame, stop in handling.stops.items():
        np.testing.assert_allclose(palm(handling.arm(frame)), stop.palm, atol=1e-9)
    palms = np.array([palm(handling.arm(k)) for k in range(HANDLING_FRAMES)])
    assert np.linalg.norm(np.diff(palms, axis=0), axis=1).max() < 0.015
    assert np.linalg.norm(np.diff(palms, 2, axis=0), axis=1).max() < 0.002
    assert np.linalg.norm(np.ptp(palms, axis=0)) > 0.2


@HANDLINGS
def test_the_flask_stands_on_the_table_but_where_it_is_held(handling):
    stood = [handling.flask(k).joint[1] + FLASK_HALF_M for k in range(handling.grasped + 1)]
    np.testing.assert_allclose(stood, TABLE_Y, atol=1e-9)
    for k in range(handling.grasped, handling.released + 1):
        np.testing.assert_allclose(handling.flask(k).joint, palm(handling.arm(k)) + FLASK_IN_PALM, atol=1e-9)


def test_a_moved_flask_stays_where_it_was_set_down():
    begun, ended = MOVING.flask(0).joint, MOVING.flask(HANDLING_FRAMES - 1).joint
    assert np.linalg.norm(ended - begun) > 0.15
    assert ended[1] + FLASK_HALF_M == pytest.approx(TABLE_Y)
    for k in range(MOVING.released, HANDLING_FRAMES):
        np.testing.assert_array_equal(MOVING.flask(k).joint, ended)


def test_the_film_shows_arm_and_flask_before_books_as_bright_as_skin():
    shelf = bookshelf(np.random.default_rng(7))
    assert shelf.shape == SIZE_PX[::-1]
    assert np.ptp(shelf[:200]) > 120
    picture = grasping_film(Scenery(noise=0.0)).render(GRASPING.limb_poses(0)).astype(float)
    changed = np.abs(picture - shelf) > 20
    for point in (GRASPING.arm(0).elbow, GRASPING.flask(0).joint):
        x, y = (round(v) for v in film_pixel(point))
        assert changed[y - 12 : y + 12, x - 8 : x + 8].mean() > 0.5
    assert not changed[:, 500:].any()


def test_the_film_is_the_same_each_time():
    first, second = (grasping_film(Scenery(seed=5)).render(MOVING.limb_poses(90)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
