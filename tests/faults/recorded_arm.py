"""A position arm that is where it was sent, and records each position that it is sent to."""

import os
import time

import numpy as np

from common.geometry import Array
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.position_arm.arm import PositionArm
from remote_site.drivers.position_arm.driver import PositionArmDriver
from remote_site.drivers.registry import DriverHost
from tests.faults.recording_driver import JOINTS, READ, RECORD, WRITE


class RecordedArm(PositionArm):
    """Its record is that of the recording driver, with the speed of the last step."""

    joints, rate_hz, lag_ms, writes_stop = JOINTS, 100.0, 20.0, True

    def __init__(self, record: str) -> None:
        self._file = os.open(record, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self._q = self._dq = np.zeros(JOINTS)

    def configure(self, setup: DriverSetup) -> None:
        """Stand where the site begins."""
        self._q = np.zeros(JOINTS) if setup.start is None else setup.start

    def read(self) -> Array:
        self._note(READ, self._q, self._dq)
        self._dq = np.zeros(JOINTS)
        return self._q

    def write(self, positions: Array) -> None:
        self._dq, self._q = (positions - self._q) * self.rate_hz, positions
        self._note(WRITE, positions, np.zeros(JOINTS))

    def stop(self) -> None:
        """Stay there."""

    def _note(self, kind: int, q: Array, dq: Array) -> None:
        record = np.zeros((), RECORD)
        record["kind"] = kind
        record["t_ns"] = record["planned_ns"] = time.monotonic_ns()
        record["motion"][0], record["motion"][1] = q, dq
        os.write(self._file, record.tobytes())


def recorded_arm(host: DriverHost) -> PositionArmDriver:
    """Its driver."""
    return PositionArmDriver(RecordedArm(str(host.options["record"])), host.clock)
