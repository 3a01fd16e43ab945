"""A camera that is dark, slow, frozen or missing is distinguished from a live one, and from the others, in a second."""

import itertools

import numpy as np
import pytest
import simplejpeg

from common.cameras.camera import Frame, Image
from common.messages.video import CameraStatus
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import is_dark
from remote_site.video.streaming.setting import StreamSetting
from remote_site.video.streaming.stream import CameraStream
from tests.present import present

MS = 1_000_000
STEP_NS = 5 * MS
FULL = StreamSetting(80, 1.0, 30.0)
RNG = np.random.default_rng(7)


def scene(level: float = 120.0, contrast: float = 40.0) -> Image:
    return np.clip(RNG.normal(level, contrast, (48, 64, 3)), 0, 255).astype(np.uint8)


class FakeCamera:
    """Gives pictures at a rate that may change, read every few milliseconds as a live camera is."""

    def __init__(self, name="side", setting=FULL):
        self.stream = CameraStream(name, VideoConfig(), noise_free=False)
        self.setting = setting
        self._now_ns, self._next_ns = 0, 0.0
        self._seq = itertools.count()
        self._frame = None

    def run(self, seconds, fps=30.0, image=scene):
        """The messages of this many seconds; 0 fps for a camera that hangs."""
        told, end_ns = [], self._now_ns + round(seconds * 1e9)
        self._next_ns = max(self._next_ns, self._now_ns)
        while self._now_ns < end_ns:
            self._now_ns += STEP_NS
            if fps and self._now_ns >= self._next_ns:
                self._frame = Frame(image(), self._now_ns, next(self._seq))
                self._next_ns += 1e9 / fps
            told.append(self.stream.take(self._frame, self.setting, self._now_ns))
        return [message for message in told if message is not None]

    def fail(self, seconds, why="camera side: unplugged; plug it in"):
        told = []
        for _ in range(round(seconds * 1e9 / STEP_NS)):
            self._now_ns += STEP_NS
            told.append(self.stream.missing(why, self._now_ns))
        return [message for message in told if message is not None]


def black():
    return scene(5.0, 2.0)


def covered():
    return np.full((48, 64, 3), 130, np.uint8)


TROUBLES = {
    CameraStatus.DARK: lambda camera: camera.run(1.0, image=black),
    CameraStatus.SLOW: lambda camera: camera.run(1.0, fps=12.0),
    CameraStatus.FROZEN: lambda camera: camera.run(1.0, fps=0.0),
    CameraStatus.MISSING: lambda camera: camera.fail(1.0),
}


@pytest.mark.parametrize("status", TROUBLES)
def test_every_trouble_is_told_within_a_second_and_ends_within_a_second(status):
    camera = FakeCamera()
    before = camera.run(3.0)
    assert {m.status for m in before} == {CameraStatus.LIVE}
    told = TROUBLES[status](camera)
    assert told[-1].status is status
    assert {m.status for m in told} <= {CameraStatus.LIVE, status}
    assert camera.run(1.0)[-1].status is CameraStatus.LIVE


@pytest.mark.parametrize("status", [CameraStatus.DARK, CameraStatus.SLOW])
def test_dark_and_slow_pictures_are_sent_as_they_are_and_marked(status):
    last = TROUBLES[status](FakeCamera())[-1]
    assert simplejpeg.decode_jpeg(last.data).shape == (48, 64, 3)
    assert last.reason


@pytest.mark.parametrize("status", [CameraStatus.FROZEN, CameraStatus.MISSING])
def test_a_frozen_or_missing_camera_sends_no_picture_but_a_reason_with_its_cure(status):
    camera = FakeCamera()
    camera.run(1.0)
    told = [m for m in TROUBLES[status](camera) if m.status is status]
    assert told
    assert all(m.data == b"" and m.reason for m in told)
    assert "check" in told[-1].reason or "plug" in told[-1].reason


def test_a_slow_camera_is_marked_with_its_real_rate():
    last = FakeCamera().run(2.0, fps=10.0)[-1]
    assert "10.0 of 30 pictures a second" in last.reason


@pytest.mark.parametrize(
    ("fps", "status"), [(16.0, CameraStatus.LIVE), (14.0, CameraStatus.SLOW), (3.0, CameraStatus.SLOW)]
)
def test_fewer_than_half_of_the_promised_pictures_are_slow(fps, status):
    assert FakeCamera().run(3.0, fps=fps)[-1].status is status


def test_one_picture_a_second_is_slow_whenever_it_is_not_frozen():
    told = FakeCamera().run(6.0, fps=1.0)[2:]
    assert {m.status for m in told} == {CameraStatus.SLOW, CameraStatus.FROZEN}
    assert all(bool(m.data) == (m.status is CameraStatus.SLOW) for m in told)


def test_a_camera_from_which_the_link_takes_every_third_picture_is_not_slow():
    told = FakeCamera(setting=StreamSetting(40, 0.5, 10.0)).run(3.0)
    assert {m.status for m in told} == {CameraStatus.LIVE}
    assert len(told) == pytest.approx(30, abs=2)
    assert simplejpeg.decode_jpeg(told[-1].data).shape == (24, 32, 3)


def test_a_camera_quicker_than_promised_is_thinned_to_what_is_promised():
    camera = FakeCamera()
    camera.run(1.0, fps=66.0)
    assert len(camera.run(3.0, fps=66.0)) == pytest.approx(90, abs=3)


def test_a_camera_a_little_quicker_than_promised_loses_no_picture():
    assert len(FakeCamera().run(4.0, fps=33.0)) == pytest.approx(132, abs=2)


def test_a_camera_behind_its_cap_is_dark_and_not_frozen():
    cap = np.zeros((48, 64, 3), np.uint8)
    assert {m.status for m in FakeCamera().run(3.0, image=lambda: cap)} == {CameraStatus.DARK}


def test_a_dark_camera_that_hangs_is_frozen():
    camera = FakeCamera()
    camera.run(1.0, image=black)
    assert camera.run(1.0, fps=0.0)[-1].status is CameraStatus.FROZEN


def test_a_dark_and_slow_camera_says_both():
    last = FakeCamera().run(2.0, fps=10.0, image=black)[-1]
    assert last.status is CameraStatus.DARK
    assert "light" in last.reason
    assert "10.0 of 30" in last.reason


def test_a_reopened_camera_that_counts_from_zero_is_not_slow():
    stream = CameraStream("side", VideoConfig(), noise_free=False)
    first = [stream.take(Frame(scene(), 33 * k * MS, k), FULL, 33 * k * MS) for k in range(1, 60)]
    later = [stream.take(Frame(scene(), 33 * k * MS, k - 200), FULL, 33 * k * MS) for k in range(200, 260)]
    assert {present(m).status for m in first + later} == {CameraStatus.LIVE}


@pytest.mark.parametrize("image", [black(), covered(), black()[:, :, 0], np.zeros((4, 4), np.uint8)])
def test_black_pictures_and_those_without_contrast_are_dark(image):
    assert is_dark(image, 32.0)


def test_a_dim_scene_with_a_lamp_is_not_dark():
    image = black()
    image[10:20, 10:20] = 220
    assert not is_dark(image, 32.0)
    assert not is_dark(scene(50.0, 15.0)[:, :, 1], 32.0)
