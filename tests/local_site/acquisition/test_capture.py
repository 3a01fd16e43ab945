"""Cameras read in threads: the newest views, and a reason when there are none."""

import queue
import threading
from typing import Any

import numpy as np

from common.cameras.camera import Frame
from common.cameras.lost_pictures import LostPictures
from common.clock import NS_PER_MS, FakeClock
from common.errors import CameraError
from common.host_clock import MonotonicClock
from local_site.acquisition.capture import Capture
from local_site.acquisition.pairing import PairingConfig
from local_site.acquisition.simulated_cameras import Beginning, SimulatedCameras
from local_site.simulation.config import SimulationConfig, StereoConfig
from local_site.simulation.operator import make_operator
from tests.common.cameras.losing_camera import LOST, LosingCamera

WAIT_S = 20.0


class ScriptedCamera:
    """Gives the frames that a test puts in; None ends it, an exception is raised."""

    def __init__(self, name, frames=()):
        self.name = name
        self.script = queue.Queue[Any]()
        for item in frames:
            self.script.put(item)
        self.closed = threading.Event()

    def read(self):
        item = self.script.get()
        if isinstance(item, Exception):
            raise item
        return item

    def close(self):
        self.closed.set()
        self.script.put(None)


def frame(k, t_ms=None):
    image = np.full((3, 4), k, np.uint8)
    return Frame(image, round((33 * k if t_ms is None else t_ms) * NS_PER_MS), k)


def start(*cameras):
    return Capture(cameras, PairingConfig(), FakeClock(0))


def test_views_come_as_soon_as_both_cameras_have_exposed():
    left, right = ScriptedCamera("left"), ScriptedCamera("right")
    capture = start(left, right)
    left.script.put(frame(1))
    assert capture.next(timeout_s=0.05) is None
    right.script.put(frame(1))
    views = capture.next(WAIT_S)
    assert [view.current.seq for view in views.views] == [1, 1]
    assert capture.next(timeout_s=0.05) is None
    assert capture.problem() is None
    capture.close()
    assert left.closed.is_set()
    assert right.closed.is_set()


def test_a_slow_taker_gets_the_newest_views_only():
    left = ScriptedCamera("left", [frame(k) for k in range(1, 6)])
    right = ScriptedCamera("right", [frame(k) for k in range(1, 6)])
    capture = start(left, right)
    newest = 0
    while newest < 5:
        views = capture.next(WAIT_S)
        assert views.views[0].current.seq > newest
        newest = views.views[0].current.seq
    left.script.put(frame(6))
    right.script.put(frame(6))
    left.script.put(frame(7))
    right.script.put(frame(7))
    while left.script.qsize() or right.script.qsize():
        pass
    capture.close()
    assert capture.next(WAIT_S).views[0].current.seq == 7


def test_a_failing_camera_is_named_and_ends_the_waiting():
    left, right = ScriptedCamera("left"), ScriptedCamera("right")
    capture = start(left, right)
    right.script.put(CameraError("camera right: unplugged; plug it in"))
    assert capture.next(WAIT_S) is None
    assert capture.ended
    assert capture.problem() == "camera right: unplugged; plug it in"
    capture.close()


def test_the_end_of_a_recording_is_said():
    left, right = ScriptedCamera("left", [None]), ScriptedCamera("right")
    capture = start(left, right)
    assert capture.next(WAIT_S) is None
    assert capture.problem() == "camera left has come to its end"
    capture.close()


def views_of_simulation(phase_offset_ms):
    small = StereoConfig(width_px=160, height_px=120, focal_px=200.0)
    config = SimulationConfig(stereo=small, fps=50.0, phase_offset_ms=phase_offset_ms)
    source = SimulatedCameras(config, make_operator(config), Beginning())
    capture = Capture(source.cameras, PairingConfig(), MonotonicClock())
    found = [capture.next(WAIT_S) for _ in range(8)]
    capture.close()
    return found


def test_synchronous_simulated_cameras_are_paired_as_they_are():
    for views in views_of_simulation(0.0):
        assert {view.current.capture_ns for view in views.views} == {views.t_ns}


def test_simulated_cameras_out_of_phase_are_interpolated():
    found = views_of_simulation(8.0)
    assert any(view.weight < 1.0 for views in found for view in views.views)
    times = [views.t_ns for views in found]
    assert times == sorted(set(times))


def test_a_camera_is_not_closed_while_it_gives_a_frame():
    """OpenCV's readers crash then."""
    reading, done = threading.Event(), []

    class Slow:
        name = "left"

        def read(self):
            reading.set()
            threading.Event().wait(0.05)
            done.append("read")
            return frame(len(done))

        def close(self):
            done.append("closed")

    capture = start(Slow())
    assert reading.wait(WAIT_S)
    capture.close()
    assert done.count("closed") == 1
    assert done[-1] == "closed"


def test_what_the_operators_cameras_lose_is_counted():
    lost = LostPictures(["left", "right"])
    capture = Capture([ScriptedCamera("A"), LosingCamera("B")], PairingConfig(), FakeClock(0), lost)
    capture.next(WAIT_S)
    assert capture.ended
    capture.close()
    assert lost.read() == {"left": 0, "right": LOST}
