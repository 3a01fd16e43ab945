"""The clock in view is read exactly through JPEG and scaling, and nowhere where there is none."""

import cv2
import numpy as np
import pytest
import simplejpeg
from hypothesis import given
from hypothesis import strategies as st

from lab.stage.clock_strip import CELLS, WRAP_MS, draw_clock, read_clock
from remote_site.video.streaming.pictures import encode_jpeg, shrunk

MS = 1_000_000
RNG = np.random.default_rng(3)


NOISE = RNG.normal(0, 5, (480, 640, 3)).astype(np.int16)


def scene():
    rough = RNG.integers(0, 255, (12, 16, 3), dtype=np.uint8)
    smooth = cv2.resize(rough, (640, 480), interpolation=cv2.INTER_CUBIC)
    return np.clip(smooth + np.roll(NOISE, RNG.integers(480), axis=0), 0, 255).astype(np.uint8)


def through_jpeg(image, quality):
    return simplejpeg.decode_jpeg(encode_jpeg(image, quality), colorspace="BGR")


@given(st.integers(0, 2**62))
def test_every_time_is_read_as_it_was_drawn(t_ns):
    image = np.full((48, 176, 3), 128, np.uint8)
    draw_clock(image, t_ns)
    assert read_clock(image) == t_ns // MS % WRAP_MS


@pytest.mark.parametrize("quality", [20, 50, 80])
@pytest.mark.parametrize("scale", [1.0, 0.75, 0.5])
def test_it_is_read_through_jpeg_and_scaling(quality, scale):
    for t_ms in RNG.integers(0, WRAP_MS, 12):
        image = scene()
        draw_clock(image, int(t_ms) * MS)
        assert read_clock(through_jpeg(shrunk(image, scale), quality)) == t_ms


def test_it_is_read_after_half_the_size_was_painted_large_again():
    image = scene()
    draw_clock(image, 123_456_789 * MS)
    painted = cv2.resize(through_jpeg(shrunk(image, 0.5), 50), (1010, 700), interpolation=cv2.INTER_LINEAR)
    assert read_clock(painted) == 123_456_789


def test_it_is_read_from_grey_pictures_too():
    image = scene()[:, :, 0].copy()
    draw_clock(image, 5 * MS)
    assert read_clock(image) == 5


def test_pictures_without_a_clock_have_no_time():
    stripes = np.tile(np.repeat(np.array([0, 255], np.uint8), 8), 40)[None].repeat(480, 0)
    assert [read_clock(scene()) for _ in range(50)] == [None] * 50
    assert read_clock(stripes) is None
    assert read_clock(np.zeros((480, 640, 3), np.uint8)) is None
    assert read_clock(RNG.integers(0, 2, (480, 640), dtype=np.uint8) * 255) is None


def test_a_picture_too_narrow_for_the_cells_has_no_time():
    assert read_clock(np.zeros((10, CELLS - 10), np.uint8)) is None


@pytest.mark.parametrize("cell", range(CELLS))
def test_one_cell_turned_over_is_noticed(cell):
    image = scene()
    draw_clock(image, 0xDEADBEEF * MS)
    left, right = (np.array([cell, cell + 1]) * 640 // CELLS).tolist()
    image[:24, left:right] = 255 - image[:24, left:right]
    assert read_clock(image) is None
