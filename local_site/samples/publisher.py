"""From arm estimate to hand sample: one session per start, a sequence, and the count of openings."""

import math
from collections.abc import Mapping
from typing import Protocol

from common.geometry import Array
from common.messages.base import Covariance, Vector3
from common.messages.hand import HandArm, Intent, PointCovariances
from local_site.authority.lease_client import Standing
from local_site.samples.gesture import OpenHand
from local_site.tracking.tracker import ArmEstimate

REASON_CHARACTERS = 400


class SampleSink(Protocol):
    """Where samples go: the link's publisher, or whoever works without a link."""

    def put(self, message: HandArm) -> None: ...


class HandPublisher:
    """Publishes hand samples of one session, each with the standing and the intent of its instant."""

    def __init__(self, publisher: SampleSink, session: int) -> None:
        self._publisher = publisher
        self._session = session
        self._seq = 0

    def publish(self, estimate: ArmEstimate, hand: OpenHand, standing: Standing, intent: Intent) -> HandArm:
        """Send one instant; the sample as sent comes back."""
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
            reason=estimate.reason[:REASON_CHARACTERS],
            thumb_inferred=estimate.thumb_inferred,
            hand_open=estimate.hand_open or hand.is_open,
            gripper_toggles=hand.toggles,
            covariance=_covariance(estimate.covariances),
            lease=standing.lease,
            clock=standing.clock,
            intent=intent,
        )
        self._seq += 1
        self._publisher.put(sample)
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
