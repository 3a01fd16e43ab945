"""A recording as a live camera: at its own pace, on this host's clock, both views from one start."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.errors import CameraError
from local_site.acquisition import rig_cameras
from local_site.acquisition.rig_cameras import PacedRecording, RecordingStart
from tests.present import present

START_NS = 41_953 * NS_PER_S
FRAME_MS = 40


class Recording:
    name = "left"
    is_closed = False

    def __init__(self, count):
        image = np.zeros((2, 2), np.uint8)
        self._frames = iter([Frame(image, k * FRAME_MS * NS_PER_MS, k) for k in range(count)])

    def read(self):
        return next(self._frames, None)

    def close(self):
        self.is_closed = True


def test_frames_are_stamped_by_the_hosts_clock_and_awaited():
    clock = FakeClock(START_NS)
    camera = PacedRecording(Recording(3), RecordingStart(clock))
    stamps = []
    while (frame := camera.read()) is not None:
        assert clock.now_ns() == frame.capture_ns
        stamps.append(frame.capture_ns - START_NS)
    assert stamps == [0, FRAME_MS * NS_PER_MS, 2 * FRAME_MS * NS_PER_MS]


def test_it_begins_when_the_first_camera_is_read_and_for_all_at_once():
    clock = FakeClock(START_NS)
    start = RecordingStart(clock)
    left, right = PacedRecording(Recording(2), start), PacedRecording(Recording(2), start)
    clock.advance_ms(700)
    first = present(left.read())
    clock.advance_ms(5)
    assert present(right.read()).capture_ns == first.capture_ns == START_NS + 700 * NS_PER_MS


def test_name_and_end_are_the_recordings():
    recording = Recording(0)
    camera = PacedRecording(recording, RecordingStart(FakeClock(0)))
    camera.close()
    assert (camera.name, recording.is_closed) == ("left", True)


def test_a_recording_that_was_cut_off_fails_as_a_camera_does(monkeypatch):
    monkeypatch.setattr(rig_cameras, "damage_of", lambda _: "camera left: cut off")
    camera = PacedRecording(Recording(1), RecordingStart(FakeClock(START_NS)))
    assert camera.read() is not None
    with pytest.raises(CameraError, match="cut off"):
        camera.read()
