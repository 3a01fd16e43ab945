"""The simulated operator as cameras: rendered in a process of its own, read like any camera."""

import multiprocessing
import os
import select
import signal
import weakref
from multiprocessing.process import BaseProcess

import cv2

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, NS_PER_S, MonotonicClock
from common.errors import CameraError
from common.process.children import die_with_parent
from common.process.service import ask_for_real_time
from local_site.calibration.rig import Rig
from local_site.simulation.beginning import Beginning
from local_site.simulation.config import SimulationConfig
from local_site.simulation.exposures import ExposureLoop, ExposureSchedule
from local_site.simulation.frame_ring import FrameRing
from local_site.simulation.hazel import SIZE_PX
from local_site.simulation.operators import filming_rig, make_operator

END_WITHIN_S = 1.0
FIFO_PRIORITY = 21


class SimulatedCameras:
    """The cameras before the simulated operator, exposing from `start_ns` on.

    He moves from then on or waits for `begin`, as configured.

    Create it in the main thread: the process that renders ends with the thread that began it.
    ConfigError when the motion is out of the arm's reach.
    """

    def __init__(self, config: SimulationConfig) -> None:
        operator = make_operator(config)
        clock = MonotonicClock()
        self.start_ns = clock.now_ns()
        self._beginning = Beginning()
        if config.motion.begins == "at_once":
            self._beginning.set(self.start_ns)
        self.rig: Rig = filming_rig(config)
        period_ns, offset_ns = round(NS_PER_S / config.fps), round(config.phase_offset_ms * NS_PER_MS)
        pace = ExposureSchedule(self.start_ns, period_ns, offset_ns, len(self.rig.cameras))
        size = SIZE_PX if config.textured else (config.stereo.width_px, config.stereo.height_px)
        channels = [_Channel(*size) for _ in self.rig.cameras]
        loop = ExposureLoop(
            operator, self._beginning, pace, clock, lambda k, image, t_ns: channels[k].publish(image, t_ns)
        )
        fork = multiprocessing.get_context("fork")
        process = fork.Process(target=_render_for_ever, args=(loop, os.getpid()), name="operator", daemon=True)
        process.start()
        self._child = _Child(process)
        self.cameras = tuple(
            SimulatedCamera(calibrated.name, channel, self._child)
            for calibrated, channel in zip(self.rig.cameras, channels, strict=True)
        )

    def begin(self, t_ns: int) -> None:
        """The operator who waited begins to move; one who moves already goes on."""
        self._beginning.set(t_ns)

    @property
    def pid(self) -> int | None:
        """The process that renders."""
        return self._child.process.pid

    def close(self) -> None:
        """End the process; reads that wait return None."""
        self._child.close()


class _Child:
    """The process that renders, and whether it was ended on purpose."""

    def __init__(self, process: BaseProcess) -> None:
        self.process = process
        self.closed = False

    def close(self) -> None:
        self.closed = True
        self.process.terminate()
        self.process.join(END_WITHIN_S)


class _Channel:
    """One camera's way between the processes: the ring of its frames, and a counter that wakes the reader."""

    def __init__(self, width_px: int, height_px: int) -> None:
        self.ring = FrameRing(width_px, height_px)
        self.wake_fd = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        weakref.finalize(self, os.close, self.wake_fd)

    def publish(self, image: Image, capture_ns: int) -> None:
        self.ring.publish(image, capture_ns)
        os.eventfd_write(self.wake_fd, 1)


class SimulatedCamera:
    """One of them; always gives the newest frame, so a slow reader misses frames instead of falling behind."""

    def __init__(self, name: str, channel: _Channel, child: _Child) -> None:
        self._name = name
        self._channel = channel
        self._child = child
        self._last = -1
        self._poll = select.poll()
        self._poll.register(channel.wake_fd, select.POLLIN)
        self._poll.register(child.process.sentinel, select.POLLIN)

    @property
    def name(self) -> str:
        return self._name

    def read(self) -> Frame | None:
        """Wait for a frame newer than the last; None once closed, CameraError when the process died."""
        while not self._child.closed:
            frame = self._channel.ring.newest(self._last)
            if frame is not None:
                self._last = frame.seq
                return frame
            ready = [fd for fd, _ in self._poll.poll()]
            if self._channel.wake_fd in ready:
                os.eventfd_read(self._channel.wake_fd)
            elif not self._child.closed:
                raise CameraError(f"the process of the simulated operator ended, camera {self._name} with it; restart")
        return None

    def close(self) -> None:
        """End the process that renders for all cameras."""
        self._child.close()


def _render_for_ever(loop: ExposureLoop, parent: int) -> None:
    """The body of the process: ends with its parent, which alone takes Ctrl-C."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    die_with_parent(parent, signal.SIGKILL)
    # Zero and not one: one would wait for OpenCV's worker threads, which a forked process has not.
    cv2.setNumThreads(0)
    # a real camera waits for no processor
    ask_for_real_time(FIFO_PRIORITY)
    while os.getppid() == parent:
        loop.expose_next()
