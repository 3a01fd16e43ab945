"""From arm estimate to hand sample: openings of the hand counted, the operator's intent merged, covariances packed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import msgspec
from msgspec import Meta
from msgspec.structs import replace

from common.clock import NS_PER_MS
from common.geometry import Array
from common.link.channels import INTENT
from common.messages.base import Covariance, Vector3
from common.messages.clutch_latch import ClutchLatch
from common.messages.hand import (
    ClockSync,
    ClutchKey,
    HandArm,
    Intent,
    OperatorIntent,
    OperatorSettings,
    PointCovariances,
)
from local_site.tracking.tracker import ArmEstimate


class GestureConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When an open hand counts."""

    hold_ms: Annotated[float, Meta(ge=0, le=1000, description="how long a change of the hand must last, ms")] = 120.0


@dataclass(frozen=True, slots=True)
class OpenHand:
    """The opening hand as a gripper toggle: debounced, counted once on the rising edge (thesis 4.2).

    Open is a hand whose fingers are stretched and seen apart: a flat one with its fingers together gives no signal.
    Holds the debounced state, since when the observation differs from it, and the count.
    """

    is_open: bool = False
    differs_since_ns: int | None = None
    toggles: int = 0

    def observe(self, estimate: ArmEstimate, config: GestureConfig) -> "OpenHand":
        """The state after an estimate; a change counts once it has lasted for `hold_ms`.

        An estimate without a wrist did not see the hand: the state stays, and a pending change starts again.
        """
        t_ns, is_open = estimate.t_ns, estimate.hand_open and not estimate.fingers_together
        if estimate.wrist is None or is_open == self.is_open:
            return OpenHand(self.is_open, None, self.toggles)
        since = self.differs_since_ns if self.differs_since_ns is not None else t_ns
        if t_ns - since < config.hold_ms * NS_PER_MS:
            return OpenHand(self.is_open, since, self.toggles)
        return OpenHand(is_open, None, self.toggles + int(is_open))


class IntentMerge:
    """Keeps the newest intent that a console or pedal of this host has sent; what is not repeated is not held.

    Without any for 200 ms, or as soon as its sender reports it, there is no intent. After such a silence, as at the
    start, holding counts only once the key was seen released: a console that comes back with its key still down moves
    nothing. Of several senders the first counts, until it is silent: what a second one reports is no release of the
    first one's key or clutch, and changes none of its settings. A clutch that was down stays so, unseen.
    """

    def __init__(self) -> None:
        self._last: OperatorIntent | None = None
        self._released = False
        self._clutch = ClutchLatch()

    def receive(self, received: OperatorIntent, now_ns: int) -> None:
        """Take an intent; one that is older than the last, from the future, or of a second sender is ignored."""
        last, intent = self._last, received.intent
        if received.sent_ns > now_ns or (last is not None and received.sent_ns <= last.sent_ns):
            return
        if last is not None:
            is_silent = last.intent is None or received.sent_ns - last.sent_ns > INTENT.stale_after_ns
            is_other = received.session != last.session
            if is_other and not is_silent:
                return
            if is_other or is_silent:
                self._interrupt()
        if intent is None:
            self._interrupt()
        self._last = received
        self._released = self._released or (intent is not None and not intent.hold)
        is_late = now_ns - received.sent_ns > INTENT.stale_after_ns
        if intent is not None and not (is_late and intent.clutch is ClutchKey.UP):
            self._clutch.see(intent.clutch)

    def at(self, now_ns: int) -> Intent | None:
        """The intent of this instant, None while nobody reports one."""
        intent = self._last.intent if self._last is not None else None
        if self._last is None or intent is None or now_ns - self._last.sent_ns > INTENT.stale_after_ns:
            self._interrupt()
            return None
        return replace(intent, hold=intent.hold and self._released, clutch=self._clutch.key)

    def _interrupt(self) -> None:
        """The reports have ceased, or are another sender's."""
        self._released = False
        self._clutch.interrupt()


def unless_in_force(intent: Intent | None, in_force: OperatorSettings | None) -> Intent | None:
    """The intent without settings that are in force at the remote site, or older: they would change nothing there."""
    settings = intent.settings if intent is not None else None
    if intent is None or settings is None or in_force is None or settings.lease != in_force.lease:
        return intent
    return replace(intent, settings=None) if settings.revision <= in_force.revision else intent


class HandSampler:
    """Makes hand samples of one session, numbered from 0."""

    def __init__(self, session: int) -> None:
        self._session = session
        self._seq = 0

    def sample(
        self,
        estimate: ArmEstimate,
        hand: OpenHand,
        lease: int,
        clock: ClockSync | None,
        intent: Intent | None,
        sent_ns: int,
        read_ns: int | None = None,
    ) -> HandArm:
        """The sample of one instant, with lease, clocks' offset and intent as they are when it is sent.

        `read_ns` is when its pictures were read from the cameras, None without pictures.
        """
        sample = HandArm(
            session=self._session,
            seq=self._seq,
            capture_ns=estimate.t_ns,
            elbow=_vector(estimate.elbow),
            wrist=_vector(estimate.wrist),
            index=_vector(estimate.index),
            thumb=_vector(estimate.thumb),
            palm=_vector(estimate.palm),
            status=estimate.status,
            reason=estimate.reason,
            thumb_inferred=estimate.thumb_inferred,
            hand_open=estimate.hand_open or hand.is_open,
            gripper_toggles=hand.toggles,
            covariance=_covariance(estimate.covariances),
            lease=lease,
            clock=clock,
            intent=intent,
            read_ns=read_ns,
            sent_ns=sent_ns,
        )
        self._seq += 1
        return sample


def _covariance(matrices: Mapping[str, Array]) -> PointCovariances | None:
    return PointCovariances(**{name: _upper(matrix) for name, matrix in matrices.items()}) if matrices else None


def _upper(matrix: Array) -> Covariance | None:
    """The upper half of a covariance (3, 3); None where it is not one, for which a receiver would refuse the sample."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix.tolist()
    upper = xx, xy, xz, yy, yz, zz
    return upper if all(map(math.isfinite, upper)) and min(xx, yy, zz) >= 0 else None


def _vector(point: Array | None) -> Vector3 | None:
    if point is None:
        return None
    x, y, z = point.tolist()
    return x, y, z
