"""Forged hand samples, and payloads that are no messages, on the wire of a cell."""

import math
import secrets
import struct
import time
from functools import partial
from random import Random
from typing import Any

import msgpack
import zenoh

from common.clock import NS_PER_MS, NS_PER_S
from common.link.channels import ENGAGEMENT, HAND, LEASE
from common.link.request_client import RequestClient
from common.messages.base import PROTOCOL_VERSION
from common.messages.codec import encode
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from common.messages.requests import EngagementAction, EngagementRequest, LeaseAction, LeaseReply, LeaseRequest
from common.messages.robot import Asker, LeaseState
from tests.common.link.secured_cell import dishonest
from tests.faults.cell_pair import CellPair
from tests.faults.pair_setup import CELL, OPERATOR, OTHERS

EVERY_S = 0.02
FLOOD_HZ = 2000
ELSEWHERE = (0.12, 0.1, 0.4)
HOME = (0.0, 0.0, 0.3)
LEAD_M_S = 0.1
MOST_COUNTED = 2**63 - 1  # what a message can hold
SHAPE = {"elbow": (0.0, 0.25, 0.0), "index": (0.02, -0.17, 0.0), "thumb": (-0.05, -0.1, 0.01)}


class Forger:
    """Puts payloads on the key of an operator's hand."""

    def __init__(self, pair: CellPair, operator: str = OPERATOR) -> None:
        self._pair = pair
        link = pair.link if operator == OPERATOR else pair.link_of(operator)
        self._publisher = link.publisher(HAND, CELL, operator=operator)

    @property
    def lease(self) -> LeaseState:
        """The lease in force; AssertionError without one."""
        lease = self._pair.state.lease
        assert lease is not None, "nobody holds the lease"
        return lease

    def sample(self, *, ahead: int, age_ms: float, **changes: object) -> HandArm:
        """A sample as the lease's holder might have sent it, a hand's breadth from his hand."""
        state, now_ns = self._pair.state, time.monotonic_ns()
        assert state.obeyed is not None, "no sample was obeyed"
        x, y, z = ELSEWHERE
        fields: dict[str, Any] = {
            "session": self.lease.session,
            "seq": max(state.obeyed.seq + ahead, 0),
            "capture_ns": now_ns - round(age_ms * NS_PER_MS),
            "lease": self.lease.number,
            "clock": ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=now_ns),
        }
        shape = {
            "elbow": (x, y + 0.25, z),
            "wrist": ELSEWHERE,
            "index": (x + 0.02, y - 0.17, z),
            "thumb": (x - 0.05, y - 0.1, z),
        }
        said = {"reason": "", "thumb_inferred": False, "hand_open": False, "gripper_toggles": 0}
        return HandArm(status=TrackingStatus.TRACKED, **(fields | shape | said | changes))

    def put(self, sample: HandArm) -> None:
        """Send a sample."""
        self._publisher.put(sample)

    def put_raw(self, payload: bytes) -> None:
        """Send bytes that may be no message."""
        self._publisher._publisher.put(payload)

    def not_finite(self, value: float) -> bytes:
        """A sample whose wrist has this value, which the codec would never send."""
        sample = self.sample(ahead=2, age_ms=5)
        fields: list[Any] = msgpack.unpackb(encode(sample))
        fields[1 + sample.__struct_fields__.index("wrist")] = struct.pack("<3f", value, 0.0, 0.3)
        packed: bytes = msgpack.packb(fields)
        return packed


def old_ones(pair: CellPair, seconds: float) -> None:
    """Repeated, overtaken and late samples."""
    forger = Forger(pair)
    for _ in range(round(seconds / EVERY_S)):
        for ahead, age_ms in ((0, 5.0), (-3, 5.0), (2, 300.0)):
            forger.put(forger.sample(ahead=ahead, age_ms=age_ms))
        time.sleep(EVERY_S)


def hostile_ones(pair: CellPair, seconds: float) -> None:
    """Random bytes, huge ones, nested ones, true samples cut short, with a byte changed, or of another version."""
    forger, rng = Forger(pair), Random(6)  # noqa: S311  # which bytes are sent is no secret
    for _ in range(round(seconds / EVERY_S)):
        good = encode(forger.sample(ahead=2, age_ms=5))
        changed = bytearray(good)
        changed[rng.randrange(40)] ^= 0xFF
        nested, other = b"\x91" * 3000, msgpack.packb([PROTOCOL_VERSION + 1, *msgpack.unpackb(good)[1:]])
        for payload in (rng.randbytes(64), bytes(2_000_000), nested, good[:-20], bytes(changed), other, b""):
            forger.put_raw(payload)
            time.sleep(EVERY_S / 7)


def infinite_ones(pair: CellPair, seconds: float) -> None:
    """Samples with NaN and infinities."""
    forger = Forger(pair)
    for k in range(round(seconds / EVERY_S)):
        forger.put_raw(forger.not_finite((math.nan, math.inf, -math.inf)[k % 3]))
        time.sleep(EVERY_S)


def foreign_ones(pair: CellPair, seconds: float) -> None:
    """Samples of an operator without the lease, and of one whose lease is over."""
    forger, session = Forger(pair, OTHERS[0]), secrets.randbits(60)
    for k in range(round(seconds / EVERY_S)):
        forger.put(forger.sample(ahead=0, age_ms=5, session=session, seq=k, lease=0))
        forger.put(forger.sample(ahead=0, age_ms=5, session=session, seq=k, lease=forger.lease.number - 1))
        time.sleep(EVERY_S)


def usurping_ones(pair: CellPair, seconds: float) -> None:
    """Another operator, with a good certificate, uses the holder's lease, session and name to lead the arm away.

    The samples go on the own key and on the holder's; the holder's name also disengages, and releases the lease.
    """
    other, (x, y, z) = OTHERS[0], HOME
    forger = Forger(pair, other)
    with dishonest(pair.setup.endpoints.control, pair.folder, f"operator.{other}", cell=CELL) as session:
        for k in range(round(seconds / EVERY_S)):
            wrist = (x, y + LEAD_M_S * k * EVERY_S, z)
            points = {name: tuple(a + b for a, b in zip(wrist, offset, strict=True)) for name, offset in SHAPE.items()}
            sample = forger.sample(ahead=10**6, age_ms=5, wrist=wrist, **points)
            forger.put(sample)
            session.put(HAND.key_for(CELL, operator=OPERATOR), encode(sample))
            time.sleep(EVERY_S)
        _request_as_the_holder(session, forger.lease)


def _request_as_the_holder(session: zenoh.Session, lease: LeaseState) -> None:
    """Disengage, and release the lease, on the holder's keys."""
    number, until_ns = secrets.randbits(60), time.monotonic_ns() + NS_PER_S
    disengage = EngagementRequest(id=number, deadline_ns=until_ns, action=EngagementAction.DISENGAGE)
    give = LeaseRequest(
        id=number, deadline_ns=until_ns, action=LeaseAction.RELEASE, session=lease.session, lease=lease.number
    )
    for key, request in (
        (ENGAGEMENT.key_for(CELL, operator=OPERATOR), encode(disengage)),
        (LEASE.key_for(CELL, operator=OPERATOR), encode(give)),
    ):
        list(session.get(key, payload=request, timeout=0.2))


def counting_ones(pair: CellPair, seconds: float) -> None:
    """Samples of the holder's hand where it is, that count as many openings as a message can hold, and again none."""
    forger, (x, y, z) = Forger(pair), HOME
    points = {name: (x + a, y + b, z + c) for name, (a, b, c) in SHAPE.items()}
    for k in range(round(seconds / EVERY_S)):
        count = MOST_COUNTED * ((k + 1) % 2)
        forger.put(forger.sample(ahead=10**6, age_ms=5, wrist=HOME, gripper_toggles=count, **points))
        time.sleep(EVERY_S)


def flood(pair: CellPair, seconds: float) -> None:
    """Two thousand samples a second of an operator without the lease."""
    forger, session = Forger(pair, OTHERS[0]), secrets.randbits(60)
    begun_s, sent = time.monotonic(), 0
    while (elapsed_s := time.monotonic() - begun_s) < seconds:
        payload = encode(forger.sample(ahead=0, age_ms=5, session=session, seq=sent, lease=0))
        for _ in range(round(elapsed_s * FLOOD_HZ) - sent):
            forger.put_raw(payload)
            sent += 1
        time.sleep(0.001)


def ask_for_lease(pair: CellPair, operator: str) -> LeaseReply:
    """The reply to another operator's site that asks for the lease."""
    make = partial(LeaseRequest, action=LeaseAction.ACQUIRE, session=secrets.randbits(60), lease=0)
    return RequestClient(pair.link_of(operator), CELL, operator=operator).ask(LEASE, make)


def consent(pair: CellPair, to: Asker) -> LeaseReply:
    """The reply to the holder's local site, which hands the lease over to who was shown to ask for it."""
    lease = Forger(pair).lease
    make = partial(LeaseRequest, action=LeaseAction.HAND_OVER, session=lease.session, lease=lease.number, to=to)
    return RequestClient(pair.link, CELL, operator=OPERATOR).ask(LEASE, make)
