"""From arm estimate to hand sample: one session per start, a sequence, and the count of openings."""

import secrets

from common.geometry import Array
from common.messages import HandArm, TrackingStatus, Vector3
from common.transport import Publisher
from local_site.gesture import OpenHand
from local_site.tracking.tracker import ArmEstimate

SESSION_BITS = 62
REASON_CHARACTERS = 400


class HandPublisher:
    """Publishes hand samples of one session."""

    def __init__(self, publisher: Publisher[HandArm]) -> None:
        self._publisher = publisher
        self._session = secrets.randbits(SESSION_BITS)
        self._seq = 0

    def publish(self, estimate: ArmEstimate, hand: OpenHand) -> HandArm:
        """Send one instant; the sample as sent comes back."""
        sample = HandArm(
            session=self._session,
            seq=self._seq,
            capture_ns=estimate.t_ns,
            elbow=_vector(estimate.elbow),
            wrist=_vector(estimate.wrist),
            index=_vector(estimate.index),
            thumb=_vector(estimate.thumb),
            status=estimate.status,
            reason=estimate.reason[:REASON_CHARACTERS],
            thumb_inferred=estimate.thumb_inferred,
            hand_open=estimate.hand_open or hand.is_open,
            gripper_toggles=hand.toggles,
        )
        self._seq += 1
        self._publisher.put(sample)
        return sample

    def publish_nothing_seen(self, t_ns: int, reason: str, hand: OpenHand) -> HandArm:
        """Say that there is no view of the operator at all, and why."""
        return self.publish(ArmEstimate(t_ns, TrackingStatus.LOST, reason), hand)


def _vector(point: Array | None) -> Vector3 | None:
    if point is None:
        return None
    x, y, z = point.tolist()
    return x, y, z
