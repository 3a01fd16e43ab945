"""A running camera: what it is asked for is verified, and its frames are stamped by its driver or by their arrival."""

import math

import cv2
import numpy as np
import pytest
from structlog.testing import capture_logs

from common.cameras.live import LiveCamera
from common.cameras.settings import CameraSettings
from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.errors import CameraError
from tests.common.cameras.fake_capture import FakeCapture

START_NS = 3600 * NS_PER_S


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock(START_NS)


def opened(capture, settings=None, wished_fps=None):
    return LiveCamera(
        "/dev/video4",
        "left",
        settings or CameraSettings(),
        wished_fps,
        open_source=lambda _source: capture,
        clock=capture.clock,
    )


def test_a_camera_that_does_what_is_asked_is_opened(clock):
    asked = CameraSettings(
        width_px=1280, height_px=720, fps=60.0, pixel_format="MJPG", exposure_ms=4.0, gain=7, focus=30
    )
    camera = opened(FakeCapture(clock), asked)
    assert str(camera.state) == "1280 x 720, MJPG, 60 fps, exposure 4 ms, gain 7, focus 30"
    assert camera.read().image.shape == (720, 1280, 3)


def test_what_is_not_given_stays_as_it_is(clock):
    capture = FakeCapture(clock)
    before = dict(capture.values)
    camera = opened(capture)
    del capture.values[cv2.CAP_PROP_BUFFERSIZE]
    assert capture.values == before
    assert str(camera.state) == "640 x 480, YUYV, 30 fps, exposure auto, gain 0, focus auto"


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"width_px": 1920, "height_px": 1080}, "gives pictures of 640 x 480, asked were 1920 x 1080"),
        ({"width_px": 1280, "height_px": 720}, "gives pictures of 640 x 480, asked were 1280 x 720"),
        ({"fps": 50.0}, "gives 60 fps, asked were 50"),
        ({"pixel_format": "NV12"}, "gives the pixel format YUYV, asked was NV12"),
        ({"focus": 12}, "has a focus of 10, asked was 12"),
    ],
)
def test_a_camera_that_does_otherwise_is_refused_with_what_it_gives(clock, asked, words):
    capture = FakeCapture(clock)
    with pytest.raises(CameraError, match=words) as refused:
        opened(capture, CameraSettings(**asked))
    assert "v4l2-ctl -d /dev/video4 --list-" in str(refused.value)
    assert capture.released


def test_all_differences_are_told_at_once(clock):
    asked = CameraSettings(width_px=1920, height_px=1080, pixel_format="MJPG", fps=100.0, focus=12)
    with pytest.raises(CameraError, match=r"pictures of 1280 x 720, .*; gives 60 fps, .*; has a focus of 10, "):
        opened(FakeCapture(clock), asked)


def test_a_control_that_the_camera_lacks_is_named(clock):
    capture = FakeCapture(clock, missing=frozenset({cv2.CAP_PROP_FOCUS, cv2.CAP_PROP_AUTOFOCUS}))
    with pytest.raises(CameraError, match="does not let a focus be set, asked was 10"):
        opened(capture, CameraSettings(focus=10))


def test_an_exposure_that_stays_automatic_is_refused(clock):
    capture = FakeCapture(clock, missing=frozenset({cv2.CAP_PROP_EXPOSURE}))
    with pytest.raises(CameraError, match="does not let an exposure be set, asked was 4 ms"):
        opened(capture, CameraSettings(exposure_ms=4.0))


def test_a_stream_cannot_be_set_and_says_so(clock):
    with pytest.raises(CameraError, match="does not let a gain be set"):
        opened(FakeCapture(clock, backend="FFMPEG"), CameraSettings(gain=3))


def test_exposure_returns_to_automatic(clock):
    capture = FakeCapture(clock)
    opened(capture, CameraSettings(exposure_ms=4.0))
    camera = opened(capture, CameraSettings(exposure_ms="auto", focus="auto"))
    assert camera.state.exposure_ms == camera.state.focus == "auto"


def test_a_wished_rate_is_asked_for_and_another_is_accepted(clock):
    camera = opened(FakeCapture(clock), wished_fps=25.0)
    assert camera.state.fps == 30.0


def test_the_drivers_stamps_are_used_with_their_own_latency(clock):
    capture = FakeCapture(clock, transfer_ms=12.0)
    camera = opened(capture, CameraSettings(latency_ms=50, stamp_latency_ms=3))
    frames = [camera.read() for _ in range(3)]
    assert camera.stamped_by_driver
    assert not any(frame.capture_estimated for frame in frames)
    assert frames[-1].capture_ns == clock.now_ns() - 15 * NS_PER_MS
    assert frames[2].capture_ns - frames[1].capture_ns == pytest.approx(NS_PER_S / 30, abs=2)


@pytest.mark.parametrize(
    "capture_of",
    [
        lambda clock: FakeCapture(clock, stamp_shift_ns=1_700_000_000 * NS_PER_S),
        lambda clock: FakeCapture(clock, stamp_shift_ns=-START_NS),
        lambda clock: FakeCapture(clock, stamp_shift_ns=6 * NS_PER_MS),
        lambda clock: FakeCapture(clock, missing=frozenset({cv2.CAP_PROP_POS_MSEC})),
        lambda clock: FakeCapture(clock, backend="FFMPEG"),
    ],
    ids=["wall clock", "since the start", "ahead", "no stamps", "another backend"],
)
def test_stamps_of_another_clock_are_not_used(clock, capture_of):
    camera = opened(capture_of(clock), CameraSettings(latency_ms=20.0))
    frame = camera.read()
    assert not camera.stamped_by_driver
    assert frame.capture_estimated
    assert frame.capture_ns == clock.now_ns() - 20 * NS_PER_MS


def test_stamps_that_go_bad_are_given_up_and_time_never_runs_backwards(clock):
    capture = FakeCapture(clock)
    camera = opened(capture, CameraSettings(latency_ms=200.0))
    first = camera.read()
    capture.stamp_shift_ns = NS_PER_S
    second = camera.read()
    capture.stamp_shift_ns = 0
    later = [camera.read() for _ in range(10)]
    assert not first.capture_estimated
    assert second.capture_ns == first.capture_ns + 1
    assert all(frame.capture_estimated for frame in later)
    assert later[-1].capture_ns == clock.now_ns() - 200 * NS_PER_MS


def test_frames_that_waited_since_the_opening_are_dropped(clock):
    capture = FakeCapture(clock, stamp_shift_ns=NS_PER_S)
    camera = opened(capture, CameraSettings(latency_ms=20.0))
    capture.waiting = 4
    clock.advance_ms(400)
    before_ns = clock.now_ns()
    frame = camera.read()
    assert frame.seq == 0
    assert capture.waiting == 0
    assert frame.capture_ns > before_ns - 20 * NS_PER_MS


class Troubled(FakeCapture):
    """A camera that spoils the pictures of some reads, by their number."""

    def __init__(self, clock, spoilt):
        super().__init__(clock)
        self.spoilt, self.reads, self.rate = spoilt, 0, 30.0

    def read(self):
        self.reads += 1
        if self.rate < 30.0:
            self.clock.advance_ms(1e3 / self.rate - 1e3 / 30.0)
        ok, image = super().read()
        spoil = self.spoilt(self.reads)
        return spoil() if spoil is not None else (ok, image)


def raises():
    raise cv2.error("cannot decode")


SPOILT = {
    "no picture": lambda: (False, None),
    "none although it says so": lambda: (True, None),
    "another size": lambda: (True, np.zeros((8, 8, 3), np.uint8)),
    "16 bits": lambda: (True, np.zeros((480, 640), np.uint16)),
    "an error": raises,
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT)
def test_a_picture_that_is_lost_is_skipped_counted_and_said_once(clock, spoil):
    capture = Troubled(clock, lambda number: spoil if number > 20 and number % 7 == 0 else None)
    camera = opened(capture)
    with capture_logs() as lines:
        frames = [camera.read() for _ in range(60)]
    assert [frame.seq for frame in frames] == list(range(60))
    assert all(frame.image.shape == (480, 640, 3) for frame in frames)
    assert camera.lost == sum(number % 7 == 0 for number in range(21, capture.reads + 1)) > 5
    assert [line["event"] for line in lines] == ["a picture was lost"]


def test_a_camera_that_gives_no_more_is_given_up_after_two_seconds(clock):
    camera = opened(Troubled(clock, lambda number: SPOILT["no picture"] if number > 20 else None))
    with pytest.raises(CameraError, match="delivers no more frames; was it unplugged"):  # noqa: PT012
        while True:
            began_ns = clock.now_ns()
            camera.read()
    assert 2.0 <= (clock.now_ns() - began_ns) / NS_PER_S < 2.2


def test_a_camera_that_is_closed_while_it_is_read_gives_up_at_once(clock):
    camera = opened(Troubled(clock, lambda number: closes if number > 20 else None))

    def closes():
        camera.close()
        return False, None

    with pytest.raises(CameraError, match="unplugged"):  # noqa: PT012
        while True:
            began_ns = clock.now_ns()
            camera.read()
    assert clock.now_ns() - began_ns < NS_PER_S / 10


def test_stamps_that_are_no_numbers_are_no_stamps(clock):
    capture = FakeCapture(clock)
    camera = opened(capture)
    camera.read()
    capture.stamp_shift_ns = math.inf
    assert camera.read().capture_estimated


def rates_said(camera, capture, rate, seconds):
    capture.rate, end_ns = rate, capture.clock.now_ns() + seconds * NS_PER_S
    with capture_logs() as lines:
        while capture.clock.now_ns() < end_ns:
            camera.read()
    return [(line["event"], line["fps"]) for line in lines]


def test_a_camera_that_states_30_and_gives_15_is_said_and_so_is_its_end(clock):
    capture = Troubled(clock, lambda _: None)
    camera = opened(capture)
    assert rates_said(camera, capture, 30.0, 20) == []
    assert rates_said(camera, capture, 29.97, 20) == []
    ((event, fps),) = rates_said(camera, capture, 15.0, 30)
    assert event == "a camera gives too few pictures"
    assert float(fps) == pytest.approx(15.0, abs=0.5)
    assert rates_said(camera, capture, 30.0, 30) == [("a camera gives as many pictures as it states", "30")]


def test_neither_a_slow_start_nor_a_slow_reader_is_the_cameras_fault(clock):
    capture = Troubled(clock, lambda _: None)
    camera = opened(capture)
    assert rates_said(camera, capture, 5.0, 1) == []
    assert rates_said(camera, capture, 30.0, 10) == []
    with capture_logs() as lines:
        for _ in range(300):
            clock.advance_ms(95)  # as long as it takes somebody to use a picture
            capture.waiting = 1
            camera.read()
    assert lines == []


@pytest.mark.parametrize(("frames", "words"), [(0, "delivers no frame; does another program use it"), (5, "unplugged")])
def test_a_camera_without_frames_says_why(clock, frames, words):
    with pytest.raises(CameraError, match=words):
        opened(FakeCapture(clock, frames=frames)).read()


def test_a_camera_that_cannot_be_opened_is_refused(clock):
    with pytest.raises(CameraError, match="cannot open /dev/video4"):
        opened(FakeCapture(clock, opens=False))
