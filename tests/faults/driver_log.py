"""What the driver received and the robot did, read from the recording driver's file: limits, stops, travel."""

from bisect import bisect_left
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, angle_between
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.safety.stopping import stop_time
from tests.faults.recording_driver import READ, RECORD, WRITE

ROUNDING = 1.00001
FASTER = ROUNDING / LEAST_FRACTION  # of a limit: a motion may be written that much sooner than planned
Records = NDArray[np.void]  # of dtype RECORD

MOVES_RAD_S = {WRITE: 1e-9, READ: 2e-3}  # what a robot measures is not quite zero


@dataclass(frozen=True)
class Worst:
    """The worst of a span as fractions of the limits: speed, acceleration, and jerk by the times of the commands."""

    speed: float
    acceleration: float
    jerk: float
    finite: bool

    @property
    def within(self) -> bool:
        return self.finite and self.speed <= ROUNDING and self.acceleration <= ROUNDING and self.jerk <= FASTER


class DriverLog:
    """A span of the record; times are ns of the monotonic clock."""

    def __init__(self, records: Records, model: ArmModel, limits: JointLimits) -> None:
        self._model, self._limits = model, limits
        self.records = records
        self.writes = records[records["kind"] == WRITE]
        self.reads = records[records["kind"] == READ]

    @classmethod
    def read(cls, path: Path, model: ArmModel, limits: JointLimits, since_ns: int) -> "DriverLog":
        """All whole records since a time; the file itself is not read before that."""
        records = np.memmap(path, RECORD, "r", shape=(path.stat().st_size // RECORD.itemsize,))
        first = bisect_left(range(len(records)), since_ns, key=lambda k: records[k]["t_ns"])
        return cls(np.array(records[first:]), model, limits)

    def worst(self) -> Worst:
        """The worst command."""
        q, dq, ddq = (self.writes["motion"][:, k] for k in range(3))
        seconds = np.maximum(np.diff(self.writes["planned_ns"]), 1)[:, None] / NS_PER_S
        follows = np.diff(self.writes["activation"]) == 0
        jerk, mean_dq = np.diff(ddq, axis=0) / seconds, np.diff(q, axis=0) / seconds
        limits = self._limits
        speed = max(_most(dq / limits.velocity), _most(mean_dq[follows] / limits.velocity) / FASTER)
        finite = bool(np.isfinite(self.writes["motion"]).all())
        return Worst(speed, _most(ddq / limits.acceleration), _most(jerk[follows] / limits.jerk), finite)

    def last_moving_ns(self, records: Records) -> int | None:
        """When the last record was made that moves; None when all rest."""
        least = MOVES_RAD_S[int(records["kind"][0])] if len(records) else 0.0
        moving = np.flatnonzero((np.abs(records["motion"][:, 1]) > least).any(axis=1))
        return int(records["t_ns"][moving[-1]]) if len(moving) else None

    def moves_after(self, t_ns: int) -> bool:
        """Whether any command or reading later than this moves."""
        return any(
            self.last_moving_ns(records[records["t_ns"] > t_ns]) is not None for records in (self.writes, self.reads)
        )

    def rest_ns(self, onset_ns: int, grace_ns: int) -> int:
        """When an arm rests that begins its quickest stop at the onset, or at any command in the grace after it.

        Of a robot that keeps its own record, the readings count.
        """
        records = self.writes if len(self.writes) else self.reads
        times = records["t_ns"]
        first, last = np.searchsorted(times, [onset_ns, onset_ns + grace_ns], side="right")
        stops = [
            max(int(write["t_ns"]), onset_ns) + round(stop_time(JointMotion(*write["motion"]), self._limits) * NS_PER_S)
            for write in records[max(first - 1, 0) : last]
        ]
        return max(stops, default=onset_ns)

    @property
    def speed_at_end(self) -> float:
        """The fastest joint's speed in the last reading, rad/s."""
        return float(np.abs(self.reads["motion"][-1, 1]).max()) if len(self.reads) else 0.0

    def travel_mm(self, since_ns: int, until_ns: int) -> float:
        """The length of the tool's path as read, mm."""
        between = self.reads[(self.reads["t_ns"] >= since_ns) & (self.reads["t_ns"] <= until_ns)]
        path = np.array([self._model.forward(q)[:3, 3] for q in between["motion"][::4, 0]]).reshape(-1, 3)
        return 1e3 * float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())

    @property
    def positions(self) -> Array:
        """The tool's position by every command, (k, 3) in m in the base frame."""
        return np.array([self._model.forward(q)[:3, 3] for q in self.writes["motion"][:, 0]]).reshape(-1, 3)

    @property
    def turned_deg(self) -> Array:
        """How far the tool has turned since the first command, by every command, (k,) in deg."""
        turns = [self._model.forward(q)[:3, :3] for q in self.writes["motion"][:, 0]]
        return np.degrees([angle_between(turns[0], turn) for turn in turns])

    @property
    def q(self) -> Array:
        """Every commanded posture, (k, n) in rad."""
        q: Array = self.writes["motion"][:, 0]
        return q

    @property
    def fastest(self) -> float:
        """The fastest joint of any command, rad/s."""
        return _most(self.writes["motion"][:, 1])

    def deceleration(self, since_ns: int, until_ns: int) -> float:
        """The hardest braking of a joint that was commanded, rad/s²."""
        between = self.writes[(self.writes["t_ns"] >= since_ns) & (self.writes["t_ns"] <= until_ns)]
        dq, ddq = between["motion"][:, 1], between["motion"][:, 2]
        return _most(np.where(dq * ddq < 0, ddq, 0.0))


def ms(ns: float) -> float:
    """Nanoseconds as milliseconds."""
    return ns / NS_PER_MS


def _most(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
