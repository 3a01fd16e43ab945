"""Feeds the codec a million hostile payloads: it refuses invalid ones, raises nothing else, and does not grow."""

import random
import resource
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from common.errors import MessageError
from common.link.channels import CHANNELS, PROCEDURES
from common.messages.base import Message
from common.messages.codec import decode

GOLDEN = Path(__file__).parents[2] / "tests" / "golden" / "valid"
PAYLOADS = 1_000_000
WARM_UP = 20_000  # one-time allocations are not growth
MOST_GROWTH_MB = 64.0
KB_PER_MB = 1024

Target = tuple[type[Message], int]
Mutation = Callable[[random.Random, bytes], bytes]


def targets() -> list[Target]:
    """Every message that can come from the wire, with its cap in bytes."""
    pushed = [(channel.message, channel.max_bytes) for channel in CHANNELS]
    asked = [(kind, p.max_bytes) for p in PROCEDURES for kind in (p.request, p.reply)]
    return list(dict.fromkeys([*pushed, *asked]))


def seeds() -> list[tuple[bytes, Target]]:
    """Valid payloads, each with a message that it is."""
    payloads = [path.read_bytes() for path in sorted(GOLDEN.glob("*.msgpack"))]
    return [(payload, target) for payload in payloads for target in targets() if verdict(payload, target) == "valid"]


def verdict(payload: bytes, target: Target) -> str:
    """ "valid", or the reason of the refusal; any other exception is a defect."""
    try:
        decode(payload, *target)
    except MessageError as error:
        return error.reason
    return "valid"


def noise(rng: random.Random, payload: bytes) -> bytes:
    """Random bytes, as long as a payload or shorter."""
    return rng.randbytes(rng.randint(0, len(payload)))


def changed(rng: random.Random, payload: bytes) -> bytes:
    """A few bytes changed."""
    spoilt = bytearray(payload)
    for _ in range(rng.randint(1, 8)):
        spoilt[rng.randrange(len(spoilt))] = rng.randrange(256)
    return bytes(spoilt)


def cut(rng: random.Random, payload: bytes) -> bytes:
    """Truncated."""
    return payload[: rng.randrange(len(payload))]


def repeated(rng: random.Random, payload: bytes) -> bytes:
    """One piece of it duplicated."""
    begin = rng.randrange(len(payload))
    return payload[:begin] + payload[begin : begin + rng.randint(1, 64)] + payload[begin:]


def typed(rng: random.Random, payload: bytes) -> bytes:
    """One byte replaced by the head of another type: extensions, infinities, and sizes that are never sent."""
    heads = [b"\xc7\xff\x05", b"\xd4\x2a\x00"]
    heads += [b"\xdf\xff\xff\xff\xff", b"\xdd\xff\xff\xff\xff", b"\xdb\x7f\xff\xff\xff"]
    heads += [b"\xc6\xff\xff\xff\xff", b"\xcb\x7f\xf0" + bytes(6), b"\xca\x7f\xc0\x00\x00", b"\xcf" + b"\xff" * 8]
    k = rng.randrange(len(payload))
    return payload[:k] + rng.choice(heads) + payload[k + 1 :]


def infinite(rng: random.Random, payload: bytes) -> bytes:
    """Bytes replaced in place by infinities and NaN, as a float of MessagePack and as a packed number has them."""
    value = rng.choice([b"\x7f\xf0" + bytes(6), b"\x00\x00\x80\x7f", b"\x00\x00\xc0\xff", b"\x00\x7c"])
    k = rng.randrange(len(payload))
    return payload[:k] + value + payload[k + len(value) :]


def nested(rng: random.Random, payload: bytes) -> bytes:
    """Lists or maps nested deeper than in any message."""
    return rng.choice([b"\x91", b"\x81\xa1a", b"\xdc\x00\x01"]) * rng.randint(1, 600) + payload[:1]


def padded(rng: random.Random, payload: bytes) -> bytes:
    """Padded to far more than its length."""
    return payload + bytes(rng.choice([1, 1000, 100_000]))


MUTATIONS: tuple[Mutation, ...] = (
    noise,
    changed,
    changed,
    changed,
    cut,
    repeated,
    typed,
    typed,
    infinite,
    nested,
    padded,
)


def fuzz(payloads: int, seed: int) -> Counter[str]:
    """The verdicts of this many payloads; any exception other than MessageError ends it."""
    rng = random.Random(seed)  # noqa: S311  # the payloads need not be secret
    known, verdicts = seeds(), Counter[str]()
    for _ in range(payloads):
        payload, target = rng.choice(known)
        verdicts[verdict(rng.choice(MUTATIONS)(rng, payload), target)] += 1
    return verdicts


def measure(payloads: int = PAYLOADS) -> dict[str, float]:
    """Payloads, verdicts, payloads per second, and the growth of the process, MB."""
    fuzz(WARM_UP, seed=0)
    before_mb = most_memory_mb()
    began = time.perf_counter()
    verdicts = fuzz(payloads, seed=1)
    seconds = time.perf_counter() - began
    growth_mb = most_memory_mb() - before_mb
    if growth_mb > MOST_GROWTH_MB:
        sys.exit(f"the process grew by {growth_mb:.0f} MB")
    counts = {reason: float(count) for reason, count in sorted(verdicts.items())}
    return {"payloads": float(payloads), **counts, "per_second": payloads / seconds, "growth_mb": growth_mb}


def most_memory_mb() -> float:
    """The peak memory of this process, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KB_PER_MB
