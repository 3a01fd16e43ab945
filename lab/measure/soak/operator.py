"""A hand that moves at random, and a wire that loses, delays, duplicates and corrupts its samples; seeded."""

import math
from dataclasses import dataclass, field
from random import Random

import msgspec
import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, rotation_from_vector
from common.messages.base import Vector3
from common.messages.hand import (
    ClockSync,
    ClutchKey,
    HandArm,
    Intent,
    Locks,
    OperatorSettings,
    PointCovariances,
    TrackingStatus,
)
from lab.stage.network.in_transit import InTransit
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.session.samples import NamedSample

SAMPLE_NS = NS_PER_S // 30
REACH_M = 0.45
TURN_RAD = 1.2
HAND = np.array([[0.0, 0.0, 0.0], [0.02, -0.17, 0.0], [-0.05, -0.1, 0.01]])  # wrist, index and thumb from the wrist
EVENT_CHANCES = {
    "lost": 0.003,
    "silent": 0.004,
    "no number": 0.006,
    "jump": 0.003,
    "doubled": 0.02,
    "delayed": 0.02,
    "another operator": 0.02,
    "poor": 0.05,
    "open": 0.01,
    "toggled": 0.01,
    "new origins": 0.01,
    "scaled": 0.01,
    "locked": 0.005,
    "clock unknown": 0.002,
    "handed over": 0.0007,
    "page silent": 0.002,
    "clutched": 0.002,
}


@dataclass
class RandomHand:
    """Moves from pose to pose, from very slowly to faster than a hand is believed to move."""

    rng: Random
    _from: Array = field(default_factory=lambda: np.zeros(6))
    _to: Array = field(default_factory=lambda: np.zeros(6))
    _begin_ns: int = 0
    _end_ns: int = 0

    def at(self, t_ns: int) -> Array:
        """Position and rotation vector (6,) in m and rad; `t_ns` never decreases."""
        while t_ns >= self._end_ns:
            self._from, self._begin_ns = self._to, self._end_ns or t_ns
            reach = [REACH_M] * 3 + [TURN_RAD] * 3
            self._to = np.array([self.rng.uniform(-most, most) for most in reach])
            away = float(np.linalg.norm(self._to[:3] - self._from[:3]))
            seconds = away / math.exp(self.rng.uniform(math.log(0.3), math.log(4.0)))
            self._end_ns = self._begin_ns + round(max(seconds, 0.1) * NS_PER_S)
        x = (t_ns - self._begin_ns) / (self._end_ns - self._begin_ns)
        pose: Array = self._from + (self._to - self._from) * (x * x * (3.0 - 2.0 * x))
        return pose


class RandomOperator:
    """The samples of a random hand as they arrive, some of them faulty; `happened` counts the faults by kind."""

    def __init__(self, rng: Random, leases: LeaseServer, now_ns: int) -> None:
        self._rng, self.leases = rng, leases
        self._hand = RandomHand(rng)
        self._wire = InTransit[NamedSample](in_order=False)
        self._capture_ns = now_ns
        self._seq = self._toggles = 0
        self._bad, self._until_ns = "", 0
        self._lease = self._acquire(1, now_ns)
        self._settings = OperatorSettings(lease=self._lease.number)
        self.happened = dict.fromkeys(EVENT_CHANCES, 0)

    def arrived(self, now_ns: int) -> list[NamedSample]:
        """The samples that have arrived, in the order of arrival."""
        while self._capture_ns <= now_ns:
            self._capture(self._capture_ns)
            self._capture_ns += SAMPLE_NS + round(self._rng.uniform(-2, 2) * NS_PER_MS)
        return self._wire.arrived(now_ns)

    def _capture(self, t_ns: int) -> None:
        kinds = [kind for kind, chance in EVENT_CHANCES.items() if self._rng.random() < chance]
        for kind in kinds:
            self.happened[kind] += 1
        self._steer(kinds)
        if "handed over" in kinds:
            self.leases.release(self._lease.number, self._lease.holder, t_ns)
            self._lease = self._acquire(self._lease.holder.session + 1, t_ns)
            self._settings = OperatorSettings(lease=self._lease.number)
        for kind in {"lost", "silent", "jump", "open", "page silent", "clutched"}.intersection(kinds):
            self._bad, self._until_ns = kind, t_ns + round(self._rng.uniform(30, 900) * NS_PER_MS)
        if t_ns >= self._until_ns:
            self._bad = ""
        self._seq += 1
        sample = NamedSample(self._lease.holder.name, self._corrupted(self._sample(t_ns), kinds))
        if self._bad != "silent":
            extra_ms = self._rng.uniform(30, 600) if "delayed" in kinds else 0.0
            self._send(sample, t_ns, extra_ms)
        if "doubled" in kinds:
            self._send(sample, t_ns, self._rng.uniform(0, 200))
        if "another operator" in kinds:
            self._send(self._foreign(sample.sample), t_ns, 0.0)

    def _send(self, sample: NamedSample, t_ns: int, extra_ms: float) -> None:
        """The sample arrives up to 15 ms and `extra_ms` later."""
        self._wire.send(sample, t_ns + round((self._rng.uniform(1, 15) + extra_ms) * NS_PER_MS))

    def _steer(self, kinds: list[str]) -> None:
        rng, settings = self._rng, self._settings
        if {"new origins", "scaled", "locked"}.intersection(kinds):
            settings = msgspec.structs.replace(settings, revision=settings.revision + 1)
        if "scaled" in kinds:
            settings = msgspec.structs.replace(settings, scale=rng.uniform(0.2, 3), rotation_scale=rng.uniform(0, 2))
        if "locked" in kinds:
            axes = [rng.random() < 0.3 for _ in range(4)]
            settings = msgspec.structs.replace(settings, locks=Locks(x=axes[0], y=axes[1], z=axes[2], roll=axes[3]))
        self._settings = settings
        self._toggles += "toggled" in kinds

    def _sample(self, t_ns: int) -> HandArm:
        pose = self._hand.at(t_ns)
        points = pose[:3] + HAND @ rotation_from_vector(pose[3:]).T
        wrist, index, thumb = (_point(point) for point in points)
        return HandArm(
            session=self._lease.holder.session,
            seq=self._seq,
            capture_ns=t_ns,
            elbow=None,
            wrist=wrist,
            index=index,
            thumb=thumb,
            status=TrackingStatus.TRACKED,
            reason="",
            thumb_inferred=False,
            hand_open=self._bad == "open",
            gripper_toggles=self._toggles,
            lease=self._lease.number,
            clock=ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=t_ns),
            intent=self._intent(),
        )

    def _intent(self) -> Intent | None:
        clutch = ClutchKey.DOWN if self._bad == "clutched" else ClutchKey.UP
        return None if self._bad == "page silent" else Intent(settings=self._settings, clutch=clutch)

    def _corrupted(self, sample: HandArm, kinds: list[str]) -> HandArm:
        rng, replace = self._rng, msgspec.structs.replace
        if "no number" in kinds:
            broken = (rng.choice([math.nan, math.inf, -math.inf]), 0.0, 0.3)
            sample = replace(sample, wrist=broken) if rng.random() < 0.5 else replace(sample, index=broken)
        if self._bad == "jump":
            sample = replace(sample, wrist=(1.0 + rng.uniform(-0.3, 0.3), rng.uniform(-0.5, 0.5), 0.3))
        if self._bad == "lost":
            sample = replace(sample, status=TrackingStatus.LOST, wrist=None, reason="not seen")
        if "poor" in kinds:
            variance = rng.uniform(0.0, 0.06) ** 2
            poor = (variance, 0.0, 0.0, variance, 0.0, variance)
            sample = replace(sample, covariance=PointCovariances(wrist=poor, index=poor, thumb=poor))
        return replace(sample, clock=None) if "clock unknown" in kinds else sample

    def _foreign(self, sample: HandArm) -> NamedSample:
        """A sample of another operator: without a lease, under an old one, or under the holder's, session and all."""
        number = self._rng.choice([0, sample.lease - 1, sample.lease])
        session = sample.session if number == sample.lease else 10**6
        forged = msgspec.structs.replace(sample, session=session, lease=number, wrist=(0.5, 0.5, 0.5), seq=10**6)
        return NamedSample("another", forged)

    def _acquire(self, session: int, now_ns: int) -> Lease:
        lease = self.leases.acquire(Holder(session, f"operator {session}"), now_ns)
        if not isinstance(lease, Lease):
            raise TypeError(lease.sentence)  # no other site holds one
        return lease


def _point(point: Array) -> Vector3:
    x, y, z = point.tolist()
    return x, y, z
