"""Traces each obeyed hand sample from its first command to the robot's encoders; pure."""

from collections import deque
from dataclasses import dataclass

import msgspec
import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.robot import Obeyed, Traced
from remote_site.drivers.link import RobotReport
from remote_site.kinematics.joints import JointMotion
from remote_site.session.samples import Accepted

UNDER_WAY = 64  # samples at most: two seconds of them
GIVEN_UP_NS = NS_PER_S
LEAST_SPEED_RAD_S = 0.005  # of an arm at rest, encoders cannot show which command it follows


@dataclass(slots=True)
class _UnderWay:
    """A sample whose command the encoders have not shown yet."""

    obeyed: Obeyed
    command_seq: int
    along: Array | None  # joint speeds (n,) of its command, None where they cannot be distinguished from rest
    reach: float  # of the command's joints (n,) along them


class Tracing:
    """Keeps the samples in transit; `traced` is the newest that the encoders have shown.

    They have shown a sample once the measured joints are as far as its first command, along that command's motion. A
    sample that found the arm at rest is not traced.
    """

    def __init__(self) -> None:
        self.traced: Traced | None = None
        self._newest: Obeyed | None = None
        self._moved: Obeyed | None = None
        self._sample: Accepted | None = None
        self._under_way: deque[_UnderWay] = deque(maxlen=UNDER_WAY)

    def obey(self, sample: Accepted, command_seq: int, command_ns: int, motion: JointMotion) -> None:
        """A command that obeys this sample was written; only the first of each counts."""
        if sample is self._sample:
            return
        self._sample = sample
        hand = sample.sample
        self._newest = Obeyed(hand.session, hand.seq, hand.capture_ns, command_ns, None)
        along = motion.dq if np.abs(motion.dq).max() >= LEAST_SPEED_RAD_S else None
        reach = 0.0 if along is None else float(motion.q @ along)
        self._under_way.append(_UnderWay(self._newest, command_seq, along, reach))

    def reported(self) -> Obeyed | None:
        """The sample for the next state: once, one whose command is newly known to have reached the robot; else the
        newest that is obeyed. A slow robot lags by several samples.
        """
        moved, self._moved = self._moved, None
        return moved or self._newest

    def see(self, reading: RobotReport) -> None:
        """Note what the robot has measured, and which command had reached it by then."""
        for one in self._under_way:
            if one.obeyed.motion_ns is None and _has_reached(reading, one.command_seq):
                self._moved = one.obeyed = msgspec.structs.replace(one.obeyed, motion_ns=reading.t_ns)
        if self._under_way and self._under_way[-1].obeyed is self._moved:
            self._newest = self._moved
        while self._under_way and _is_over(self._under_way[0], reading):
            self._under_way.popleft()
        self._look_for_shown(reading)

    def _look_for_shown(self, reading: RobotReport) -> None:
        """The newest sample that the encoders show counts; those before it are over."""
        for k in reversed(range(len(self._under_way))):
            traced = _shown(self._under_way[k], reading)
            if traced is not None:
                self.traced = traced
                for _ in range(k + 1):
                    self._under_way.popleft()
                return


def _has_reached(reading: RobotReport, command_seq: int) -> bool:
    return reading.obeyed_seq is not None and reading.obeyed_seq >= command_seq


def _is_over(one: _UnderWay, reading: RobotReport) -> bool:
    nothing_to_show = one.along is None and one.obeyed.motion_ns is not None
    return nothing_to_show or reading.t_ns - one.obeyed.command_ns > GIVEN_UP_NS


def _shown(one: _UnderWay, reading: RobotReport) -> Traced | None:
    """The sample's whole path once the measured joints are as far as its command, along that command's motion."""
    obeyed = one.obeyed
    if obeyed.motion_ns is None or one.along is None or float(reading.q @ one.along) < one.reach:
        return None
    times = (obeyed.capture_ns, obeyed.command_ns, obeyed.motion_ns, reading.t_ns)
    return Traced(obeyed.session, obeyed.seq, *times)
