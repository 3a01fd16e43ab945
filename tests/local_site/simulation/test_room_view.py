"""The operator in a room: pictures in colour, the same outline as in the dark, skin of every tone, repeatability."""

import cv2
import msgspec
import numpy as np
import pytest

from common.errors import ConfigError
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from local_site.simulation.room.scenery import draw_office

SHARP = PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0)
OFFICE = RoomConfig(scene="office")


def config(room=OFFICE, picture=SHARP, motion="pick_and_place", seed=1, **stereo):
    return SimulationConfig(
        room=room, picture=picture, seed=seed, motion=MotionConfig(name=motion), stereo=StereoConfig(**stereo)
    )


def empty_room(asked, view):
    size = asked.stereo.width_px, asked.stereo.height_px
    return draw_office(stereo_pair(asked.stereo)[view], size, np.random.default_rng(asked.seed))


@pytest.mark.parametrize("size", [(640, 480, 800.0), (1280, 720, 1600.0), (1280, 960, 1600.0)])
def test_pictures_are_in_colour_at_every_size(size):
    width, height, focal = size
    for image in SimulatedOperator(config(width_px=width, height_px=height, focal_px=focal)).render(0.0):
        assert image.shape == (height, width, 3)
        assert image.dtype == np.uint8


@pytest.mark.parametrize("k1", [0.0, -0.1])
@pytest.mark.parametrize("t_s", [0.0, 9.3])
def test_the_arm_covers_the_same_pixels_as_in_the_dark(t_s, k1):
    asked = config(k1=k1)
    dark = SimulatedOperator(msgspec.structs.replace(asked, room=RoomConfig())).render(t_s)
    for view, (grey, colour) in enumerate(zip(dark, SimulatedOperator(asked).render(t_s), strict=True)):
        changed = np.abs(colour.astype(int) - empty_room(asked, view)).max(axis=2) > 0
        arm = grey > 20
        assert not np.any(changed & ~cv2.dilate(arm.view(np.uint8), np.ones((3, 3))).astype(bool))
        # A pixel of skin may happen to have the colour of what is behind it.
        assert np.count_nonzero(changed & arm) > 0.99 * np.count_nonzero(arm)


def test_skin_has_the_tone_that_was_asked_for_and_shading():
    means = []
    for skin in ("light", "medium", "dark"):
        asked = config(RoomConfig(scene="office", skin=skin))
        dark = SimulatedOperator(msgspec.structs.replace(asked, room=RoomConfig())).render(0.0)[0]
        arm = SimulatedOperator(asked).render(0.0)[0][dark > 120]
        blue, green, red = arm.mean(axis=0)
        assert red > green > blue
        assert arm[:, 1].std() > 5
        means.append(arm.mean())
    assert means[0] > means[1] + 20 > means[2] + 40


def test_the_same_seed_gives_the_same_room_and_another_another():
    first, again, other = (SimulatedOperator(config(picture=PictureConfig(), seed=seed)) for seed in (1, 1, 2))
    for t_s in (0.0, 3.3):
        pictures = [np.stack(o.render(t_s)).astype(int) for o in (first, again, other)]
        assert np.array_equal(pictures[0], pictures[1])
        assert np.abs(pictures[0] - pictures[2]).mean() > 5


def test_noise_has_the_asked_strength_and_no_bias():
    clean = SimulatedOperator(config()).render(0.0)[0].astype(float)
    noisy = SimulatedOperator(config(picture=PictureConfig(blur_sigma_px=0.0, noise_sigma=3.0))).render(0.0)[0]
    within = (clean > 30) & (clean < 225)
    assert (noisy - clean)[within].std() == pytest.approx(3.0, rel=0.05)
    assert abs((noisy - clean)[within].mean()) < 0.05


def test_markers_need_the_dark():
    with pytest.raises(ValueError, match="dark"):
        SimulationConfig(markers=True, room=OFFICE)


def test_an_arm_out_of_reach_is_refused_in_a_room_too():
    with pytest.raises(ConfigError):
        SimulatedOperator(SimulationConfig(room=OFFICE, motion=MotionConfig(wrist=(0.0, 0.0, 1.4))))
