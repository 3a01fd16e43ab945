"""A hand whose samples have numbers that no hand makes, and that the wire accepts all the same."""

import random
from functools import partial
from typing import Any

from common.messages.codec import decode, encode
from common.messages.hand import ClockSync, HandArm, Intent, Locks, OperatorSettings, PointCovariances, TrackingStatus
from tests.remote_site.remote_loop import LEASE, hand

COUNTS = 0, 1, 63, 64, 2**31, 2**53, 2**62, 2**63 - 1
METRES = 0.0, -0.0, 1e-40, 0.1, -0.3, 1.0, 1e4, -1e19, 3e38, -3e38
VARIANCES = 0.0, 1e-300, 1e-6, 1e-2, 1e30
NAMES = "wrist", "index", "thumb", "elbow", "palm"


class HostileHand:
    """Draws samples that the wire accepts, some with a believable time."""

    def __init__(self, seed: int) -> None:
        self._chance = random.Random(seed)  # noqa: S311  # samples to try, the same each time

    def _count(self, now_ns: int) -> int:
        near_ns = max(0, now_ns + round(self._chance.gauss(-2e7, 2e7)))
        return self._chance.choice((*COUNTS, near_ns, near_ns, near_ns))

    def _point(self) -> tuple[float, float, float] | None:
        draw = partial(self._chance.choice, METRES)
        return None if self._chance.random() < 0.1 else (draw(), draw(), draw())

    def _covariances(self) -> PointCovariances | None:
        def of_point() -> Any:
            return tuple(self._chance.choice(VARIANCES) for _ in range(6))

        return None if self._chance.random() < 0.5 else PointCovariances(**{name: of_point() for name in NAMES})

    def _intent(self) -> Intent | None:
        locks = Locks(z=self._chance.random() < 0.5)
        settings = OperatorSettings(lease=LEASE, revision=self._chance.choice(COUNTS), scale=5.0, locks=locks)
        return self._chance.choice((None, Intent(hold=True, settings=settings), Intent(assist="x" * 64)))

    def sample(self, seq: int, now_ns: int) -> HandArm:
        """A sample as it arrives."""
        chance = self._chance
        local_ns = chance.choice((0, 0, *(2**k for k in (40, 55, 63)))) * chance.choice((1, -1))
        clock = ClockSync(
            remote_minus_local_ns=max(-(2**63), min(local_ns, 2**63 - 1)),
            uncertainty_ns=chance.choice((0, 10**6, *COUNTS)),
            measured_ns=self._count(now_ns),
            remote_ahead_ns=chance.choice((None, 0, 1, -(2**40), 2**63 - 1, -(2**63))),
        )
        points = {name: self._point() for name in NAMES}
        changes: dict[str, Any] = points | {
            "gripper_toggles": chance.choice(COUNTS),
            "covariance": self._covariances(),
            "clock": chance.choice((None, clock, clock)),
            "intent": self._intent(),
            "read_ns": self._count(now_ns),
            "sent_ns": self._count(now_ns),
            "reason": "x" * chance.randrange(400),
            "thumb_inferred": chance.random() < 0.5,
        }
        sample = hand(
            chance.choice((seq, *COUNTS)),
            self._count(now_ns),
            session=chance.choice((7, *COUNTS)),
            status=chance.choice(tuple(TrackingStatus)),
            **changes,
        )
        return decode(encode(sample), HandArm, 4096)
