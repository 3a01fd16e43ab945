"""Validation of hand samples: in order, young, finite and plausible, or rejected with the reason; pure."""

import math
from collections import Counter
from dataclasses import replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, ClockOffset
from common.geometry import Array, angle_between
from common.mapping.shown_hand import shown_orientation, shown_position
from common.messages.hand import ClockSync, HandArm, HandPoint, TrackingStatus
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.samples import Accepted, Rejected
from remote_site.teleop.certainty import certainty_of, elbow_is_certain
from remote_site.teleop.turn_certainty import FREE, turn_speeds

OFFSET_VALID_NS = 5 * NS_PER_S  # an older measurement of the clocks no longer counts


class OrientationGate:
    """Withholds the orientation while the hand opens, is open or closes, and after any turn too fast to be meant.

    A tip taken for another and an opening hand both look like a sudden turn. The orientation counts again once it has
    been calm for `turn_settle_ms`.
    """

    def __init__(self, config: SafetyConfig) -> None:
        self._fastest_rad_s = math.radians(config.hand_turn_deg_s)
        self._settle_ns = round(config.turn_settle_ms * NS_PER_MS)
        self._last: tuple[Array, int] | None = None
        self._calm_since_ns = 0

    def judge(self, operator_R_hand: Array | None, born_ns: int) -> Array | None:
        """The orientation (3 x 3) if it may act, None otherwise; `born_ns` rises from call to call."""
        if operator_R_hand is None:
            self._last = None
            return None
        if self._last is None or self._speed_rad_s(operator_R_hand, self._last, born_ns) > self._fastest_rad_s:
            self._calm_since_ns = born_ns
        self._last = operator_R_hand, born_ns
        return operator_R_hand if born_ns - self._calm_since_ns >= self._settle_ns else None

    @staticmethod
    def _speed_rad_s(operator_R_hand: Array, last: tuple[Array, int], born_ns: int) -> float:
        before, before_ns = last
        return angle_between(operator_R_hand, before) * NS_PER_S / max(born_ns - before_ns, 1)


class SampleValidator:
    """Judges samples one by one; `rejected` counts refusals by code, `clock` is the newest clock offset.

    Every sample here was sent under the lease in force, so none is of a former session or another site.
    """

    def __init__(self, config: SafetyConfig, point: HandPoint = HandPoint.WRIST) -> None:
        self._config, self._point = config, point
        self._latch_ns = round(config.t_latch_ms * NS_PER_MS)
        self.rejected: Counter[Code] = Counter()
        self.clock: ClockSync | None = None
        self._newest: HandArm | None = None
        self._last: Accepted | None = None
        self._jumps = 0
        self._gate = OrientationGate(config)

    def accept(self, sample: HandArm, soft_ns: int, now_ns: int) -> Accepted | Rejected:
        """Accepted, or Rejected with the first rule that was broken; only samples with a valid time are remembered.

        It may be `soft_ns` old.
        """
        offset = clock_offset(sample.clock, now_ns)
        if isinstance(offset, Reason):
            return self.refuse(offset)
        self.clock = sample.clock
        age_ns = offset.age_ns(sample.capture_ns, now_ns)
        broken = self._time(sample, age_ns, soft_ns)
        if broken is not None:
            return self.refuse(broken)
        new_session = self._remember(sample)
        judged = self._judge(sample, now_ns - age_ns, new_session)
        if isinstance(judged, Rejected):
            return replace(judged, new_session=new_session, sample=sample)
        self._jumps, self._last = 0, judged
        return judged

    def refuse(self, why: Reason, *, hand_lost: bool = False, latch: bool = False) -> Rejected:
        """Refuse a sample, and count it."""
        self.rejected = self.rejected + Counter((why.code,))  # a new one: snapshots keep the old
        return Rejected(why, hand_lost, latch)

    def _judge(self, sample: HandArm, born_ns: int, new_session: bool) -> Accepted | Rejected:
        shown_at = shown_position(sample, self._point)
        if shown_at is None or sample.status in (TrackingStatus.LOST, TrackingStatus.INITIALISING):
            return self.refuse(_not_tracked(sample), hand_lost=True)
        certainty = certainty_of(sample.covariance, self._point, self._config.certainty)
        if certainty.position == 0.0:
            return self.refuse(self._poor(certainty.sigma_mm), hand_lost=True)
        position = np.array(shown_at)
        if not math.isfinite(sum(shown_at)):
            return self.refuse(reason(Code.NOT_FINITE, what=self._point))
        if (jump := self._jump(position, sample.capture_ns)) is not None:
            return self._jumped(jump)
        shown = shown_orientation(sample)
        speeds = turn_speeds(sample, shown, self._config) if shown is not None else FREE
        orientation = self._gate.judge(shown if any(speeds) else None, born_ns)
        elbow = sample.elbow if elbow_is_certain(sample.covariance, self._config.certainty) else None
        return Accepted(sample, position, orientation, born_ns, new_session, certainty.position, speeds, elbow)

    def _poor(self, sigma_mm: float) -> Reason:
        if sigma_mm == math.inf:
            return reason(Code.NO_COVARIANCE, point=self._point)
        limit_mm = self._config.certainty.position_poor_mm
        return reason(Code.UNCERTAIN, point=self._point, sigma_mm=sigma_mm, limit_mm=limit_mm)

    def _time(self, sample: HandArm, age_ns: int, soft_ns: int) -> Reason | None:
        if age_ns < 0:
            return reason(Code.FUTURE, ahead_ms=-age_ns / NS_PER_MS)
        # Whatever its number: one that was damaged does not make all samples after it old.
        newest = self._newest
        if newest is not None and sample.session == newest.session and sample.capture_ns <= newest.capture_ns:
            return _repeated(sample, newest)  # whatever its age: a copy that came last says nothing about the newest
        if age_ns > soft_ns:
            return reason(Code.STALE, age_ms=age_ns / NS_PER_MS, limit_ms=soft_ns / NS_PER_MS)
        return None

    def _remember(self, sample: HandArm) -> bool:
        """Note the sample as the newest; True when it opens a new local session after another."""
        new_session = self._newest is not None and sample.session != self._newest.session
        if new_session:
            self._last, self._jumps = None, 0
        self._newest = sample
        return new_session

    def _jump(self, position: Array, capture_ns: int) -> Reason | None:
        if self._last is None:
            return None
        # by the sender's own clock: what is known of its offset changes with every measurement on a bad link
        interval_ns = capture_ns - self._last.sample.capture_ns
        if interval_ns > self._latch_ns:
            return None
        distance = math.dist(position.tolist(), self._last.position.tolist())
        if distance <= self._config.hand_speed_m_s * interval_ns / NS_PER_S + self._config.hand_noise_m:
            return None
        return reason(Code.JUMP, point=self._point, distance_mm=distance * 1e3, interval_ms=interval_ns / NS_PER_MS)

    def _jumped(self, jump: Reason) -> Rejected:
        self._jumps += 1
        if self._jumps < self._config.jumps_to_latch:
            return self.refuse(jump)
        latch = reason(Code.JUMPS, point=self._point, count=self._jumps)
        self._last, self._jumps = None, 0
        return self.refuse(latch, latch=True)


def clock_offset(clock: ClockSync | None, now_ns: int) -> ClockOffset | Reason:
    """The local clock minus ours, as the sample states it, or why that cannot be used."""
    if clock is None or clock.measured_ns > now_ns:
        return reason(Code.NO_OFFSET)
    age_ns = now_ns - clock.measured_ns
    if age_ns > OFFSET_VALID_NS:
        return reason(Code.OLD_OFFSET, age_ms=age_ns / NS_PER_MS, limit_ms=OFFSET_VALID_NS / NS_PER_MS)
    return ClockOffset(-clock.remote_minus_local_ns, clock.uncertainty_ns)


def _repeated(sample: HandArm, newest: HandArm) -> Reason:
    if sample.seq == newest.seq:
        return reason(Code.DUPLICATE, seq=sample.seq)
    return reason(Code.OLD, seq=sample.seq, newest=newest.seq)


def _not_tracked(sample: HandArm) -> Reason:
    code = {TrackingStatus.LOST: Code.LOST, TrackingStatus.INITIALISING: Code.INITIALISING}.get(
        sample.status, Code.NO_WRIST
    )
    return reason(code, reason=sample.reason)
