"""The simulated operator's cameras: exposed on time, each rendered in a process of its own, read like any camera."""

import math
import mmap
import multiprocessing
import os
import select
import signal
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.process import BaseProcess

import cv2
import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import CameraError
from common.host_clock import MonotonicClock
from common.process.children import die_with_parent, leave_stops_to_parent, show_as
from common.process.service import ask_for_real_time
from local_site.calibration.rig import Rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hazel import SIZE_PX
from local_site.simulation.operator import Operator, filming_rig

END_WITHIN_S = 1.0
FIFO_PRIORITY = 21
SLOTS = 4
WRITING = -1
UNSET = -1

Publish = Callable[[int, Image, int], None]


class Beginning:
    """The time when the simulated operator began to move, ns; processes forked later see it as soon as it is set."""

    def __init__(self) -> None:
        self._t_ns = np.frombuffer(mmap.mmap(-1, 8), np.int64)
        self._t_ns[0] = UNSET

    def set(self, t_ns: int) -> None:
        """The motion begins at this time; later calls change nothing."""
        if self._t_ns[0] == UNSET:
            self._t_ns[0] = t_ns

    def elapsed_s(self, t_ns: int) -> float:
        """Return how long the operator has been moving at a time, s: zero before the beginning."""
        begun_ns = int(self._t_ns[0])
        return 0.0 if begun_ns == UNSET else max(0.0, (t_ns - begun_ns) / NS_PER_S)

    def time_ns(self, elapsed_s: float) -> int:
        """Return the time at which the operator has been moving for so long, ns."""
        return int(self._t_ns[0]) + round(elapsed_s * NS_PER_S)


@dataclass(frozen=True, slots=True)
class Exposure:
    """An instant at which these cameras (0 left, 1 right) expose."""

    t_ns: int
    cameras: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ExposureSchedule:
    """Absolute deadlines of these cameras: the left one every period, the right one of two `offset_ns` later."""

    start_ns: int
    period_ns: int
    offset_ns: int
    cameras: tuple[int, ...] = (0, 1)

    def after(self, t_ns: int) -> Exposure:
        """The first exposure later than this time."""
        first = {k: self.start_ns + k * self.offset_ns for k in self.cameras}
        times = {k: start + max(0, (t_ns - start) // self.period_ns + 1) * self.period_ns for k, start in first.items()}
        soonest = min(times.values())
        return Exposure(soonest, tuple(k for k, time_ns in times.items() if time_ns == soonest))


class ExposureLoop:
    """Renders the operator when the cameras expose; an exposure more than a period late is skipped."""

    def __init__(
        self, operator: Operator, beginning: Beginning, schedule: ExposureSchedule, clock: Clock, publish: Publish
    ) -> None:
        self._operator = operator
        self._beginning = beginning
        self._schedule = schedule
        self._clock = clock
        self._publish = publish
        self._last_ns = schedule.start_ns - 1

    def expose_next(self) -> None:
        """Wait for the next exposure, then render what was to be seen at that instant, however late we are awake."""
        oldest_ns = self._clock.now_ns() - self._schedule.period_ns
        exposure = self._schedule.after(max(self._last_ns, oldest_ns))
        self._last_ns = exposure.t_ns
        self._clock.sleep_until_ns(exposure.t_ns)
        t_s = self._beginning.elapsed_s(exposure.t_ns)
        filmed_s = (exposure.t_ns - self._schedule.start_ns) / NS_PER_S
        images = self._operator.render(t_s, exposure.cameras, filmed_s)
        for camera, image in zip(exposure.cameras, images, strict=True):
            self._publish(camera, image, exposure.t_ns)


class SimulatedCameras:
    """The cameras before a simulated operator, exposing from `start_ns` on.

    The operator moves from then on, or waits for `begin`, as configured; `beginning` tells when that was.

    Create it in the main thread: the processes that render end with the thread that began them.
    """

    def __init__(self, config: SimulationConfig, operator: Operator, beginning: Beginning) -> None:
        self._beginning = beginning
        clock = MonotonicClock()
        self.start_ns = clock.now_ns()
        if config.motion.begins == "at_once":
            beginning.set(self.start_ns)
        self.rig: Rig = filming_rig(config)
        period_ns, offset_ns = round(NS_PER_S / config.fps), round(config.phase_offset_ms * NS_PER_MS)
        size = SIZE_PX if config.textured else (config.stereo.width_px, config.stereo.height_px)
        rings = [FrameRing(*size, in_colour=config.room.scene != "dark") for _ in self.rig.cameras]

        def publish(camera: int, image: Image, t_ns: int) -> None:
            rings[camera].publish(image, t_ns)

        def filming(camera: int) -> _RenderingProcess:
            schedule = ExposureSchedule(self.start_ns, period_ns, offset_ns, (camera,))
            return _RenderingProcess(ExposureLoop(operator, beginning, schedule, clock, publish))

        self._renderers = [filming(k) for k in range(len(rings))]
        self.cameras = tuple(
            SimulatedCamera(calibrated.name, ring, renderer)
            for calibrated, ring, renderer in zip(self.rig.cameras, rings, self._renderers, strict=True)
        )

    def begin(self, t_ns: int) -> None:
        """Start the motion of an operator that waits for it; no effect on one that already moves."""
        self._beginning.set(t_ns)

    def close(self) -> None:
        """End the processes; reads that wait return None."""
        for renderer in self._renderers:
            renderer.close()


class _RenderingProcess:
    """The process that renders, and whether it was ended on purpose."""

    def __init__(self, loop: ExposureLoop) -> None:
        fork = multiprocessing.get_context("fork")
        self.process: BaseProcess = fork.Process(
            target=_render_for_ever, args=(loop, os.getpid()), name="operator", daemon=True
        )
        self.process.start()
        self.closed = False

    def close(self) -> None:
        self.closed = True
        self.process.kill()
        self.process.join(END_WITHIN_S)


class FrameRing:
    """The last pictures of one camera in shared memory, for one writer and one reader, which inherit it by fork.

    No `SharedRecord`: its checksum and its copies as bytes would delay each picture by 0.25 ms at 640 x 480 and by
    2.6 ms at 1920 x 1080, against 0.02 and 0.1 ms here. A slot's number is `WRITING` while its picture changes; a
    reader that finds the number changed reads again. `wake_fd` becomes readable with each picture.
    """

    def __init__(self, width_px: int, height_px: int, in_colour: bool = False) -> None:
        shape = (height_px, width_px, 3) if in_colour else (height_px, width_px)
        stamp_bytes = 8 * (2 * SLOTS + 1)
        memory = mmap.mmap(-1, stamp_bytes + SLOTS * math.prod(shape))
        stamps = np.frombuffer(memory, np.int64, 2 * SLOTS + 1)
        self._newest, self._numbers, self._times_ns = stamps[:1], stamps[1 : SLOTS + 1], stamps[SLOTS + 1 :]
        pixels = np.frombuffer(memory, np.uint8, offset=stamp_bytes)
        self._pictures = pixels.reshape(SLOTS, *shape)
        self._newest[0] = -1
        self._numbers[:] = WRITING
        self.wake_fd = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        weakref.finalize(self, os.close, self.wake_fd)

    def publish(self, image: Image, capture_ns: int) -> None:
        """Make this picture, (H, W) or (H, W, 3) as the ring was made for, the newest."""
        number = int(self._newest[0]) + 1
        slot = number % SLOTS
        self._numbers[slot] = WRITING
        self._pictures[slot] = image
        self._times_ns[slot] = capture_ns
        self._numbers[slot] = number
        self._newest[0] = number
        os.eventfd_write(self.wake_fd, 1)

    def newest(self, after: int) -> Frame | None:
        """A copy of the newest picture, None when its number is not above `after`."""
        while (number := int(self._newest[0])) > after:
            slot = number % SLOTS
            frame = Frame(self._pictures[slot].copy(), int(self._times_ns[slot]), number)
            if int(self._numbers[slot]) == number:
                return frame
        return None


class SimulatedCamera:
    """One of them; always gives the newest frame, so a slow reader misses frames instead of falling behind."""

    def __init__(self, name: str, ring: FrameRing, renderer: _RenderingProcess) -> None:
        self.name = name
        self._ring = ring
        self._renderer = renderer
        self._last = -1
        self._poll = select.poll()
        self._poll.register(ring.wake_fd, select.POLLIN)
        self._poll.register(renderer.process.sentinel, select.POLLIN)

    def read(self) -> Frame | None:
        """Wait for a frame newer than the last; None once closed, CameraError when the process died."""
        while not self._renderer.closed:
            frame = self._ring.newest(self._last)
            if frame is not None:
                self._last = frame.seq
                return frame
            ready = [fd for fd, _ in self._poll.poll()]
            if self._ring.wake_fd in ready:
                os.eventfd_read(self._ring.wake_fd)
            elif not self._renderer.closed:
                raise CameraError(f"the process of the simulated operator ended, camera {self.name} with it; restart")
        return None

    def close(self) -> None:
        """End the process that renders for it."""
        self._renderer.close()


def _render_for_ever(loop: ExposureLoop, parent: int) -> None:
    """The body of the process: ends with its parent, which alone handles Ctrl-C and SIGTERM."""
    signal.set_wakeup_fd(-1)
    leave_stops_to_parent()
    die_with_parent(parent, signal.SIGKILL)
    show_as("filmed")
    # Zero and not one: one would wait for OpenCV's worker threads, which a forked process does not have.
    cv2.setNumThreads(0)
    # a real camera waits for no processor
    ask_for_real_time(FIFO_PRIORITY)
    while os.getppid() == parent:
        loop.expose_next()
