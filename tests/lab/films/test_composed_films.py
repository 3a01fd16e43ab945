"""Films composed of recordings: a clean matte, and the recorded truth on an arm in skin before a room."""

from itertools import islice

import cv2
import numpy as np
import pytest

from lab.films.arm.skin import TONES
from lab.films.composed import ComposedFilm, composed_film, cut_out
from lab.films.scenes import RECORDINGS
from lab.films.surroundings import FilmSetting
from local_site.calibration.triangulation import project
from tests.present import present

needs_recordings = pytest.mark.skipif(not RECORDINGS.exists(), reason="the recordings are not here")
WALL, ARM, RADIUS = 9, 150, 30


def disc(radius=RADIUS):
    """A bright disc before a dark wall, its edge mixed over two pixels, with noise."""
    rows, columns = np.mgrid[0:120, 0:160]
    distance = np.hypot(rows - 60.0, columns - 70.0)
    share = np.clip(radius + 1.0 - distance, 0.0, 2.0) / 2.0
    noise = np.random.default_rng(1).normal(0.0, 1.5, share.shape)
    return np.clip(WALL + share * (ARM - WALL) + noise, 0, 255).astype(np.uint8)


def test_the_matte_covers_what_the_arm_covers():
    cutout = present(cut_out(disc()))
    assert cutout.matte.sum() / 255.0 == pytest.approx(np.pi * RADIUS**2, rel=0.03)
    rows, columns = np.nonzero(cutout.matte > 128)
    assert (rows.mean() + cutout.top, columns.mean() + cutout.left) == pytest.approx((60.0, 70.0), abs=0.3)


def test_no_dark_rim_is_left_at_the_edge():
    cutout = present(cut_out(disc()))
    assert cutout.grey[cutout.matte > 64].min() > ARM - 15


def test_where_all_is_dark_there_is_no_arm():
    assert cut_out(np.full((120, 160), WALL, np.uint8)) is None


@needs_recordings
@pytest.mark.parametrize("tone", list(TONES))
def test_the_truth_lies_on_skin_of_the_tone(tone):
    film = composed_film(ComposedFilm(name="x", recording="yz", tone=tone, setting=FilmSetting(room="office")))
    instant = next(islice(film.instants(), 12, None))
    for view, matrix in zip(instant.views.views, film.rig.matrices, strict=True):
        arm = present(instant.truth).arm
        middle = (arm.elbow + arm.wrist) / 2
        x, y = np.round(project(matrix, middle)).astype(int)
        blue, green, red = view.current.image[y - 4 : y + 5, x - 4 : x + 5].reshape(-1, 3).mean(axis=0)
        assert red > 1.1 * green > 1.1 * blue
    light = cv2.cvtColor(np.array([[TONES[tone]]], np.uint8), cv2.COLOR_RGB2GRAY)[0, 0]
    assert 0.3 * light < green < 1.3 * light


@needs_recordings
def test_the_room_is_without_the_arm_first_and_every_recorded_instant_follows():
    film = composed_film(ComposedFilm(name="x", recording="yz", empty_s=1.0))
    instants = list(film.instants())
    assert [i.truth is None for i in instants] == [True] * 15 + [False] * 70
    assert [i.views.views[0].current.seq for i in instants] == list(range(85))
    empty, shown = (instants[k].views.views[0].current.image.astype(int) for k in (14, 15))
    share = np.mean(np.abs(empty - shown).max(axis=2) > 12)
    assert 0.02 < share < 0.4
