"""Readings from an arm's positions as they come: stamped, with speeds, each only once, and nothing while they fail."""

import math
from collections import deque

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.driver import GripperReading, RobotReading
from remote_site.drivers.position_arm.calls import Calls, Measurement


class SpeedOverWindow:
    """The mean speed since the newest positions that are at least `window_ns` old.

    That is the difference smoothed by a moving average: it shows the speed of half a window ago, and passes changes
    of it up to 0.44 / window (-3 dB). One count of an encoder more or less changes it by a count per window, at most.
    """

    def __init__(self, window_ns: int) -> None:
        self._window_ns = window_ns
        self._measured: deque[tuple[int, Array]] = deque()

    def add(self, t_ns: int, q: Array) -> Array | None:
        """The speeds (n,) in rad/s at new positions (n,) in rad; None until they cover a window.

        `t_ns` is later than at the last call.
        """
        measured = self._measured
        measured.append((t_ns, q))
        while len(measured) > 1 and measured[1][0] <= t_ns - self._window_ns:
            measured.popleft()
        first_ns, first = measured[0]
        if t_ns - first_ns < self._window_ns:
            return None
        speeds: Array = (q - first) * (NS_PER_S / (t_ns - first_ns))
        return speeds


class ArmReadings:
    """The readings of `joints` joints, with speeds over `window_ns`."""

    def __init__(self, calls: Calls, joints: int, window_ns: int, clock: Clock) -> None:
        self._calls, self._joints, self._window_ns, self._clock = calls, joints, window_ns, clock
        self._speed = SpeedOverWindow(window_ns)
        self._newest: RobotReading | None = None
        self._newest_ns = 0
        self._failure: BaseException | None = None

    def newest(self) -> RobotReading:
        """The newest reading, without fault; raises what the arm has raised until it is read again.

        DriverError until there is one with speeds. Positions that are not finite are a reading: they are a fault.
        """
        try:
            measurement = self._calls.measure()
            if measurement is not None:
                self._take(measurement)
                self._failure = None
        except BaseException as error:
            self._failure = error
            raise
        if self._failure is not None:
            raise self._failure.with_traceback(None)  # or it would grow with each turn
        if self._newest is None:
            raise DriverError(f"the arm has not been measured for {self._window_ns / NS_PER_MS:g} ms yet")
        return self._newest

    def _take(self, measured: Measurement) -> None:
        """One with the stamp of the last is not new; one that lies ahead is refused, or it would bar those after it."""
        before_ns, ahead_ns = self._newest_ns - measured.t_ns, measured.t_ns - self._clock.now_ns()
        if ahead_ns > 0:
            ahead = f"the arm's positions were measured {ahead_ns / NS_PER_MS:g} ms in the future"
            raise DriverError(f"{ahead}; stamp them by the clock of the DriverHost")
        if before_ns > 0:
            raise DriverError(f"the arm's positions were measured {before_ns / NS_PER_MS:g} ms before the last ones")
        if before_ns == 0:
            return
        self._newest_ns = measured.t_ns
        finite = bool(np.isfinite(measured.q).all())
        speeds = self._speed.add(measured.t_ns, measured.q) if finite else np.full(self._joints, math.nan)
        if speeds is None:
            return
        gripper = None if measured.opening_m is None else GripperReading(measured.opening_m, None)
        self._newest = RobotReading(measured.t_ns, measured.q, speeds, gripper, None, None)
