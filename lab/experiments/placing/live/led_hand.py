"""The hand of a simulated operator that another program of this host leads: poses with their times, from a socket."""

import os
import socket
import weakref
from bisect import bisect_right
from collections import deque
from collections.abc import Callable

import msgspec
import numpy as np
import structlog

from common.clock import NS_PER_S
from common.geometry import Array
from lab.visual_operator.at_console.led_pose import LedPose, LedPoses

KEPT_NS = NS_PER_S
LARGEST = 1 << 16

DECODER: msgspec.json.Decoder[tuple[LedPose, ...]] = msgspec.json.Decoder(LedPoses)


class LedPoseHistory:
    """The poses of the last second and those to come, in order; the hand moves evenly from one to the next."""

    def __init__(self) -> None:
        self._poses: deque[LedPose] = deque()

    def add(self, pose: LedPose) -> None:
        """Take the next pose; one that is not later than the last has no effect."""
        poses = self._poses
        if poses and pose.t_ns <= poses[-1].t_ns:
            return
        poses.append(pose)
        while len(poses) > 2 and poses[1].t_ns < pose.t_ns - KEPT_NS:
            poses.popleft()

    def at(self, t_ns: int) -> tuple[Array, Array, float]:
        """Offset (3,) m, turn (3,) as a rotation vector and openness at a time; the hand rests before and after all."""
        if not self._poses:
            return np.zeros(3), np.zeros(3), 0.0
        after = self._after(t_ns)
        a, b = self._poses[max(after - 1, 0)], self._poses[min(after, len(self._poses) - 1)]
        part = (t_ns - a.t_ns) / (b.t_ns - a.t_ns) if b.t_ns > a.t_ns else 0.0
        offset = (1 - part) * np.array(a.offset) + part * np.array(b.offset)
        turn = (1 - part) * np.array(a.turn) + part * np.array(b.turn)
        return offset, turn, (1 - part) * a.openness + part * b.openness

    def openings_until(self, t_ns: int) -> int:
        """Count how often the hand had begun to open by a time of the last second."""
        after = self._after(t_ns)
        return self._poses[after - 1].openings if after else 0

    def _after(self, t_ns: int) -> int:
        return bisect_right(self._poses, t_ns, key=lambda pose: pose.t_ns)


class LedHand:
    """The hand's `Path` as it comes to a socket; `time_of` gives the time, ns, of the path's seconds.

    Each process that films it listens at a socket of its own: this name, a dot, and the process's number.
    """

    def __init__(self, name: str, time_of: Callable[[float], int]) -> None:
        self._name, self._time_of = name, time_of
        self._history = LedPoseHistory()
        self._listening: tuple[int, socket.socket] | None = None  # and in which process

    def at(self, t_s: float) -> tuple[Array, Array, float]:
        """Return where the hand is, by all that has come until now."""
        self._receive()
        return self._history.at(self._time_of(t_s))

    def openings_until(self, t_s: float) -> int:
        """Count how often the hand has begun to open."""
        self._receive()
        return self._history.openings_until(self._time_of(t_s))

    def _receive(self) -> None:
        listening = self._listen()
        while True:
            try:
                poses = DECODER.decode(listening.recv(LARGEST))
            except BlockingIOError:
                return
            except msgspec.DecodeError as error:
                structlog.get_logger().warning("led hand refused", reason=str(error))
                continue
            for pose in poses:
                self._history.add(pose)

    def _listen(self) -> socket.socket:
        """This process's own socket."""
        if self._listening is not None and self._listening[0] == os.getpid():
            return self._listening[1]
        own = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC | socket.SOCK_NONBLOCK)
        weakref.finalize(self, own.close)
        own.bind(f"{self._name}.{os.getpid()}")
        self._listening = os.getpid(), own
        return own
