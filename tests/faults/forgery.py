"""Hand samples that nobody's tracker has made, and payloads that are none, on the wire of a cell."""

import math
import secrets
import time
from functools import partial
from random import Random

import msgpack
import msgspec

from common.clock import NS_PER_MS
from common.link.channels import HAND, LEASE
from common.link.request_client import RequestClient
from common.messages.codec import encode
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from common.messages.requests import LeaseAction, LeaseReply, LeaseRequest
from tests.faults.cell_pair import CELL, CellPair

EVERY_S = 0.02
FLOOD_HZ = 2000
ELSEWHERE = (0.12, 0.1, 0.4)


class Forger:
    """Puts payloads on the hand's key."""

    def __init__(self, pair: CellPair) -> None:
        self._pair = pair
        self._publisher = pair.link.publisher(HAND, CELL)

    def sample(self, *, ahead: int, age_ms: float, **changes: object) -> HandArm:
        """A sample as the lease's holder might have sent it, a hand's breadth from his hand."""
        state, now_ns = self._pair.state, time.monotonic_ns()
        x, y, z = ELSEWHERE
        fields = {
            "session": state.lease.session,
            "seq": max(state.obeyed.seq + ahead, 0),
            "capture_ns": now_ns - round(age_ms * NS_PER_MS),
            "lease": state.lease.number,
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
        """Send what may be no message."""
        self._publisher._publisher.put(payload)

    def not_finite(self, value: float) -> bytes:
        """A sample whose wrist is at such a value, as the codec would never send it."""
        fields = msgspec.to_builtins(self.sample(ahead=2, age_ms=5))
        return msgpack.packb(fields | {"wrist": (value, 0.0, 0.3)})


def old_ones(pair: CellPair, seconds: float) -> None:
    """Repeated, overtaken and late samples."""
    forger = Forger(pair)
    for _ in range(round(seconds / EVERY_S)):
        for ahead, age_ms in ((0, 5.0), (-3, 5.0), (2, 300.0)):
            forger.put(forger.sample(ahead=ahead, age_ms=age_ms))
        time.sleep(EVERY_S)


def hostile_ones(pair: CellPair, seconds: float) -> None:
    """Random bytes, huge ones, nested ones, true samples cut short, with a byte changed, or of another version."""
    forger, luck = Forger(pair), Random(6)  # noqa: S311  # which bytes are sent is no secret
    for _ in range(round(seconds / EVERY_S)):
        good = msgpack.packb(msgspec.to_builtins(forger.sample(ahead=2, age_ms=5)))
        changed = bytearray(good)
        changed[luck.randrange(40)] ^= 0xFF
        nested, other = b"\x91" * 3000, good.replace(b"version", b"vversion")
        for payload in (luck.randbytes(64), bytes(2_000_000), nested, good[:-20], bytes(changed), other, b""):
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
    forger, session = Forger(pair), secrets.randbits(60)
    for k in range(round(seconds / EVERY_S)):
        forger.put(forger.sample(ahead=0, age_ms=5, session=session, seq=k, lease=0))
        forger.put(forger.sample(ahead=0, age_ms=5, session=session, seq=k, lease=pair.state.lease.number - 1))
        time.sleep(EVERY_S)


def flood(pair: CellPair, seconds: float) -> None:
    """Two thousand samples a second of an operator without the lease."""
    forger, session = Forger(pair), secrets.randbits(60)
    begun_s, sent = time.monotonic(), 0
    while (elapsed_s := time.monotonic() - begun_s) < seconds:
        payload = encode(forger.sample(ahead=0, age_ms=5, session=session, seq=sent, lease=0))
        for _ in range(round(elapsed_s * FLOOD_HZ) - sent):
            forger.put_raw(payload)
            sent += 1
        time.sleep(0.001)


def ask_for_lease(pair: CellPair, operator: str) -> LeaseReply:
    """What another operator's site hears when it asks for the lease."""
    session = secrets.randbits(60)
    make = partial(LeaseRequest, action=LeaseAction.ACQUIRE, session=session, operator=operator, lease=0)
    return RequestClient(pair.link, CELL).ask(LEASE, make)
