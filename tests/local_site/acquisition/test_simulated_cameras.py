"""The simulated cameras as a source: paced exposures, shared frames, and a process that ends with its parent."""

import os
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.errors import CameraError, ConfigError
from lab.stage.waiting import until
from local_site.acquisition.simulated_cameras import (
    SLOTS,
    Beginning,
    Exposure,
    ExposureLoop,
    ExposureSchedule,
    FrameRing,
    SimulatedCameras,
)
from local_site.simulation.config import BodyConfig, MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator, make_operator
from local_site.simulation.room.config import RoomConfig
from tests.present import present

SMALL = StereoConfig(width_px=160, height_px=120, focal_px=200.0)
CONFIG = SimulationConfig(stereo=SMALL, fps=100.0)


def test_synchronous_cameras_expose_together_at_absolute_deadlines():
    pace = ExposureSchedule(start_ns=1000, period_ns=100, offset_ns=0)
    assert pace.after(0) == Exposure(1000, (0, 1))
    assert pace.after(1000) == Exposure(1100, (0, 1))
    assert pace.after(1567) == Exposure(1600, (0, 1))


def test_the_second_camera_keeps_its_phase():
    pace = ExposureSchedule(start_ns=1000, period_ns=100, offset_ns=30)
    times, t_ns = [], 0
    for _ in range(4):
        exposure = pace.after(t_ns)
        t_ns = exposure.t_ns
        times.append((t_ns, exposure.cameras))
    assert times == [(1000, (0,)), (1030, (1,)), (1100, (0,)), (1130, (1,))]


def test_cameras_that_are_filmed_apart_expose_together():
    paces = [ExposureSchedule(start_ns=1000, period_ns=100, offset_ns=30, cameras=(k,)) for k in (0, 1)]
    assert [pace.after(1000) for pace in paces] == [Exposure(1100, (0,)), Exposure(1030, (1,))]


def loop(clock, published, offset_ms=0.0):
    pace = ExposureSchedule(clock.now_ns() + 5 * NS_PER_MS, 10 * NS_PER_MS, round(offset_ms * NS_PER_MS))

    def keep(camera, image, t_ns):
        published.append((camera, t_ns, image))

    return ExposureLoop(SimulatedOperator(SimulationConfig(stereo=SMALL)), Beginning(), pace, clock, keep)


def test_both_views_of_a_pair_carry_the_instant_of_the_rendered_pose():
    clock, published = FakeClock(7), list[Any]()
    exposures = loop(clock, published)
    exposures.expose_next()
    exposures.expose_next()
    assert [(camera, t_ns) for camera, t_ns, _ in published] == [
        (0, 7 + 5 * NS_PER_MS),
        (1, 7 + 5 * NS_PER_MS),
        (0, 7 + 15 * NS_PER_MS),
        (1, 7 + 15 * NS_PER_MS),
    ]
    expected = SimulatedOperator(SimulationConfig(stereo=SMALL)).render(0.0)
    assert np.array_equal(published[0][2], expected[0])
    assert np.array_equal(published[1][2], expected[1])


def test_a_slow_renderer_skips_exposures_instead_of_falling_behind():
    clock, published = FakeClock(0), list[Any]()
    exposures = loop(clock, published)
    exposures.expose_next()
    clock.advance_ms(43.0)
    exposures.expose_next()
    assert published[-1][1] == 45 * NS_PER_MS  # late, and as it was to be seen then
    exposures.expose_next()
    assert published[-1][1] == 55 * NS_PER_MS


def test_an_offset_camera_is_rendered_though_the_other_took_its_time():
    clock, published = FakeClock(0), list[Any]()
    exposures = loop(clock, published, offset_ms=2.0)
    for _ in range(6):
        exposures.expose_next()
        clock.advance_ms(4.0)
    assert [camera for camera, _, _ in published] == [0, 1, 0, 1, 0, 1]


def test_the_ring_gives_the_newest_frame_once():
    ring = FrameRing(4, 3)
    assert ring.newest(-1) is None
    for k in range(SLOTS + 3):
        ring.publish(np.full((3, 4), k, np.uint8), 100 + k)
    frame = present(ring.newest(-1))
    assert (frame.seq, frame.capture_ns, frame.image.max()) == (SLOTS + 2, 100 + SLOTS + 2, SLOTS + 2)
    assert ring.newest(frame.seq) is None
    ring.publish(np.zeros((3, 4), np.uint8), 200)
    assert frame.image.max() == SLOTS + 2
    assert present(ring.newest(frame.seq)).seq == SLOTS + 3


def test_the_ring_carries_colour():
    ring = FrameRing(4, 3, in_colour=True)
    image = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)
    ring.publish(image, 100)
    assert np.array_equal(present(ring.newest(-1)).image, image)


def filmed(config):
    """The cameras before the operator that a configuration asks for."""
    return SimulatedCameras(config, make_operator(config), Beginning())


def test_cameras_in_an_office_give_pictures_in_colour():
    source = filmed(SimulationConfig(stereo=SMALL, room=RoomConfig(scene="office")))
    try:
        for camera in source.cameras:
            assert camera.read().image.shape == (120, 160, 3)
    finally:
        source.close()


@pytest.mark.slow
@pytest.mark.parametrize("begins", ["at_once", "when_engaged"])
def test_an_operator_moves_once_he_begins(begins):
    picture, motion = PictureConfig(noise_sigma=0.0), MotionConfig(name="figure_of_eight", begins=begins, still_s=0.0)
    config = SimulationConfig(stereo=SMALL, fps=100.0, picture=picture, motion=motion)
    source = filmed(config)
    still = SimulatedOperator(config).render(0.0)[0]
    try:
        time.sleep(0.5)
        assert np.array_equal(source.cameras[0].read().image, still) == (begins == "when_engaged")
        source.begin(time.monotonic_ns() - NS_PER_S)
        source.begin(time.monotonic_ns() + NS_PER_S)
        time.sleep(0.2)
        assert not np.array_equal(source.cameras[0].read().image, still)
    finally:
        source.close()


@pytest.fixture
def cameras():
    source = filmed(CONFIG)
    yield source
    source.close()


def test_frames_arrive_in_order_with_one_exposure_for_both_views(cameras):
    left = [cameras.cameras[0].read() for _ in range(5)]
    right = [cameras.cameras[1].read() for _ in range(5)]
    assert [cameras.cameras[0].name, cameras.cameras[1].name] == ["left", "right"]
    for frames in (left, right):
        assert all(frame.image.shape == (120, 160) for frame in frames)
        assert all(np.diff([frame.seq for frame in frames]) >= 1)
        assert all(np.diff([frame.capture_ns for frame in frames]) > 0)
        assert frames[0].capture_ns >= cameras.start_ns
        assert {(frame.capture_ns - cameras.start_ns) % (10 * NS_PER_MS) for frame in frames} == {0}


def test_a_closed_source_gives_none(cameras):
    assert cameras.cameras[1].read() is not None
    cameras.close()
    assert cameras.cameras[0].read() is None
    assert cameras.cameras[1].read() is None


def test_a_dead_renderer_is_a_camera_error(cameras):
    cameras.cameras[0].read()
    os.kill(cameras._renderers[0].process.pid, signal.SIGKILL)
    with pytest.raises(CameraError, match="simulated operator ended, camera left"):
        list(iter(cameras.cameras[0].read, None))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_signal_is_left_to_the_parent(cameras, number):
    cameras.cameras[0].read()
    os.kill(cameras._renderers[0].process.pid, number)
    assert all(cameras.cameras[0].read() is not None for _ in range(5))


PARENT = """
import sys, time
import structlog
from local_site.simulation.config import SimulationConfig, StereoConfig
from local_site.acquisition.simulated_cameras import Beginning, SimulatedCameras
from local_site.simulation.operator import make_operator
structlog.configure(logger_factory=structlog.PrintLoggerFactory(sys.stderr))
config = SimulationConfig(stereo=StereoConfig(width_px=160, height_px=120, focal_px=200.0))
cameras = SimulatedCameras(config, make_operator(config), Beginning())
cameras.cameras[0].read()
print(cameras._renderers[0].process.pid, flush=True)
time.sleep(60)
"""


def running(pid):
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_renderer_dies_with_its_parent():
    with subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE, text=True) as parent:
        renderer = int(present(parent.stdout).readline())
        assert running(renderer)
        parent.kill()
    until(lambda: not running(renderer), "the end of its renderer", 20.0)


def test_a_motion_out_of_reach_is_refused_before_any_process_starts():
    with pytest.raises(ConfigError, match="cannot reach"):
        filmed(SimulationConfig(body=BodyConfig(forearm_length=0.15), motion=MotionConfig()))


def test_the_default_picture_is_noisy_so_that_a_still_hand_is_not_taken_for_a_frozen_camera():
    assert PictureConfig().noise_sigma > 0
