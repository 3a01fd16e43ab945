"""The operator in a room: pictures in colour, the same outline as in the dark, skin of every tone, repeatability."""

from functools import cache

import cv2
import msgspec
import numpy as np
import pytest

from common.errors import ConfigError
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig

SHARP = PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0)
OFFICE = RoomConfig(scene="office")


def config(room=OFFICE, picture=SHARP, motion="pick_and_place", seed=1, **stereo):
    return SimulationConfig(
        room=room, picture=picture, seed=seed, motion=MotionConfig(name=motion), stereo=StereoConfig(**stereo)
    )


@cache
def sharp(asked):
    """The operator without noise, whose pictures depend on the time alone: made once, and shared."""
    assert asked.picture == SHARP
    return SimulatedOperator(asked)


@pytest.fixture(autouse=True, scope="module")
def _operators_end_with_the_module():
    yield
    sharp.cache_clear()


def with_skin(asked, skin):
    return msgspec.structs.replace(asked, room=msgspec.structs.replace(asked.room, skin=skin))


def in_the_dark(asked):
    return msgspec.structs.replace(asked, room=RoomConfig())


def skin_seen(asked, t_s, view=0, filmed_s=None):
    """Where skin is (H, W): what differs between light skin and dark."""
    light, dark = (
        sharp(with_skin(asked, skin)).render(t_s, (view,), filmed_s)[0].astype(int) for skin in ("light", "dark")
    )
    return np.abs(light - dark).max(axis=2) > 0


def dark_arm(asked, t_s, view=0):
    """The arm's pixels (H, W) in the dark."""
    return sharp(in_the_dark(asked)).render(t_s, (view,))[0] > 20


@pytest.mark.slow
@pytest.mark.parametrize("size", [(640, 480, 800.0), (1280, 720, 1600.0), (1280, 960, 1600.0)])
def test_pictures_are_in_colour_at_every_size(size):
    width, height, focal = size
    for image in sharp(config(width_px=width, height_px=height, focal_px=focal)).render(0.0):
        assert image.shape == (height, width, 3)
        assert image.dtype == np.uint8


@pytest.mark.slow
@pytest.mark.parametrize("k1", [0.0, -0.1])
@pytest.mark.parametrize("t_s", [0.0, 9.3])
@pytest.mark.parametrize("view", [0, 1])
def test_skin_covers_the_same_pixels_as_in_the_dark(view, t_s, k1):
    asked = config(k1=k1)
    skin, arm = skin_seen(asked, t_s, view), dark_arm(asked, t_s, view)
    # Coverage of a few hundredths is no grey level in the dark, but a tint in colour.
    assert not np.any(skin & ~cv2.dilate(arm.view(np.uint8), np.ones((3, 3))).astype(bool))
    # A sleeve that is nearer than the arm hides its end, about the right-most pixel.
    rows, columns = np.nonzero(arm & ~skin)
    assert len(rows) < 0.12 * np.count_nonzero(arm)
    end = np.flatnonzero(arm.any(axis=0))[-1]
    assert columns.min(initial=end) > end - 60


@pytest.mark.slow
def test_skin_has_the_tone_that_was_asked_for_and_shading():
    means = []
    for skin in ("light", "medium", "dark"):
        asked = with_skin(config(), skin)
        dark = sharp(in_the_dark(asked)).render(0.0)[0]
        arm = sharp(asked).render(0.0)[0][dark > 120]
        blue, green, red = arm.mean(axis=0)
        assert red > green > blue
        assert arm[:, 1].std() > 5
        means.append(arm.mean())
    assert means[0] > means[1] + 20 > means[2] + 40


@pytest.mark.slow
def test_the_same_seed_gives_the_same_room_and_another_another():
    first, again, other = (SimulatedOperator(config(picture=PictureConfig(), seed=seed)) for seed in (1, 1, 2))
    for t_s in (0.0, 3.3):
        pictures = [np.stack(o.render(t_s)).astype(int) for o in (first, again, other)]
        assert np.array_equal(pictures[0], pictures[1])
        assert np.abs(pictures[0] - pictures[2]).mean() > 5


@pytest.mark.slow
def test_noise_has_the_asked_strength_and_no_bias():
    clean = sharp(config()).render(0.0)[0].astype(float)
    noisy = SimulatedOperator(config(picture=PictureConfig(blur_sigma_px=0.0, noise_sigma=3.0))).render(0.0)[0]
    within = (clean > 30) & (clean < 225)
    assert (noisy - clean)[within].std() == pytest.approx(3.0, rel=0.05)
    assert abs((noisy - clean)[within].mean()) < 0.05


@pytest.mark.slow
def test_the_operator_steps_in_after_the_empty_room():
    asked = config(msgspec.structs.replace(OFFICE, empty_s=1.0), motion="hold")
    assert not skin_seen(asked, 0.0, filmed_s=0.9).any()
    assert np.array_equal(skin_seen(asked, 0.0, filmed_s=2.0), skin_seen(config(motion="hold"), 0.0))


def test_the_truth_comes_in_with_the_operator():
    operator = sharp(config(msgspec.structs.replace(OFFICE, empty_s=1.0), motion="hold"))
    ways = [operator.truth(0.0, filmed_s).wrist[0] - operator.truth(0.0, 5.0).wrist[0] for filmed_s in (1.1, 1.4, 1.9)]
    assert ways[0] > 1.0 > ways[1] > 0.0 == ways[2]


def test_the_points_are_those_of_an_operator_who_has_come_in():
    operator = sharp(config(msgspec.structs.replace(OFFICE, empty_s=1.0), motion="hold"))
    there = operator.truth(0.0, 5.0)
    assert all(np.array_equal(point, getattr(there, name)) for name, point in operator.points(0.0).items())


@pytest.mark.slow
def test_a_long_sleeve_leaves_only_the_hand():
    bare, covered = (skin_seen(config(msgspec.structs.replace(OFFICE, sleeve=s)), 0.0) for s in ("short", "long"))
    assert not np.any(covered & ~bare)
    assert 0.1 < np.count_nonzero(covered) / np.count_nonzero(bare) < 0.5


@pytest.mark.slow
def test_a_watch_darkens_the_wrist_only():
    pictures = [
        sharp(config(msgspec.structs.replace(OFFICE, watch=watch))).render(0.0)[0].astype(int)
        for watch in (False, True)
    ]
    operator, camera = sharp(config()), stereo_pair(StereoConfig())[0]
    wrist = camera.pixels(camera.to_camera(operator.truth(0.0).wrist))
    rows, columns = np.nonzero(np.abs(pictures[0] - pictures[1]).max(axis=2) > 40)
    assert len(rows) > 40
    assert np.hypot(columns - wrist[0], rows - wrist[1]).max() < 45


def test_what_only_an_office_shows_is_refused_in_the_dark():
    with pytest.raises(ValueError, match="office"):
        SimulationConfig(room=RoomConfig(watch=True))


def test_markers_need_the_dark():
    with pytest.raises(ValueError, match="dark"):
        SimulationConfig(markers=True, room=OFFICE)


def test_an_arm_out_of_reach_is_refused_in_a_room_too():
    with pytest.raises(ConfigError):
        SimulatedOperator(SimulationConfig(room=OFFICE, motion=MotionConfig(wrist=(0.0, 0.0, 1.4))))
