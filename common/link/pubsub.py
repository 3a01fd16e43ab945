"""Publishers and subscriptions of channels: the newest messages, capped in rate, typed."""

import time
from collections.abc import Callable
from typing import Generic, TypeVar

import structlog
import zenoh

from common.clock import NS_PER_S
from common.errors import MessageError, TransportError
from common.link.channels import Channel
from common.link.lanes import Copies, LanePublisher
from common.link.rate_cap import RateCap
from common.link.tap import MessageTap, untapped
from common.messages.base import Message
from common.messages.codec import decode, encode

M = TypeVar("M", bound=Message)


class Publisher(Generic[M]):
    """Publishes messages on one key; under congestion they are dropped, it never blocks.

    `payload_bytes` is the size of the newest.
    """

    def __init__(
        self, publisher: zenoh.Publisher, tap: MessageTap = untapped, in_lanes: LanePublisher | None = None
    ) -> None:
        """`in_lanes` takes each message first."""
        self._publisher, self._key, self._tap = publisher, str(publisher.key_expr), tap
        self._in_lanes = in_lanes
        self.payload_bytes = 0

    def put(self, message: M) -> None:
        """Send a message; MessageError when it holds a number that is not finite."""
        payload = encode(message)
        self.payload_bytes = len(payload)
        if self._in_lanes is not None:
            self._in_lanes.put(payload)
        self._publisher.put(payload)
        self._tap(self._key, payload, sent=True)

    @property
    def has_listener(self) -> bool:
        """Return whether this key has a subscriber now, as far as this session knows."""
        return bool(self._publisher.matching_status.matching)  # type: ignore[attr-defined]  # its stub says bool


class Latest(Generic[M]):
    """A subscription that keeps the newest messages of one key, as many as the channel's depth."""

    def __init__(
        self,
        subscriber: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]",
        channel: Channel[M],
        tap: MessageTap = untapped,
    ) -> None:
        self._subscriber = subscriber
        self._channel, self._tap = channel, tap
        self._cap = RateCap(channel.max_hz, channel.depth + 1)
        self._copies = Copies() if channel.in_lanes else None

    @property
    def depth(self) -> int:
        """The number of newest messages that are kept."""
        return self._channel.depth

    def take(self) -> M | None:
        """The oldest message kept and not taken yet, None without one; MessageError for an invalid payload."""
        taken = self._taken()
        return None if taken is None else self._decode(*taken)

    def take_named(self) -> tuple[str, M] | None:
        """As `take`, with the operator whose key the message came on; MessageError also for a key that is nobody's."""
        taken = self._taken()
        return None if taken is None else (self._channel.operator_in(taken[0]), self._decode(*taken))

    def wait(self) -> M:
        """Block until a message comes; MessageError for an invalid payload, TransportError once the link is closed.

        In a flood it pauses, so that it takes no more than the channel's `max_hz`; Zenoh keeps the newest meanwhile.
        """
        while True:
            self._hold_back()
            try:
                sample = self._subscriber.recv()
            except zenoh.ZError as error:
                raise TransportError("the link was closed") from error
            self._cap.passed(time.monotonic_ns())
            payload = sample.payload.to_bytes()
            if not self._is_copy(payload):
                return self._decode(str(sample.key_expr), payload)

    def feed(self, take: Callable[[M, int], None]) -> None:
        """Pass each message with its arrival time (ns) to `take` until the link is closed; ignore invalid payloads."""
        while True:
            try:
                message = self.wait()
            except MessageError:
                continue
            except TransportError:
                return
            take(message, time.monotonic_ns())

    def close(self) -> None:
        """Receive nothing more; not while another thread waits for a message."""
        self._subscriber.undeclare()  # type: ignore[no-untyped-call]  # zenoh leaves it unannotated

    def _hold_back(self) -> None:
        was_flooded, pause_ns = self._cap.flooded, self._cap.pause_ns(time.monotonic_ns())
        if self._cap.flooded and not was_flooded:
            self._warn()
        if pause_ns:
            time.sleep(pause_ns / NS_PER_S)

    def _warn(self) -> None:
        key, max_hz = str(self._subscriber.key_expr), self._channel.max_hz
        sentence = (
            f"{key} is flooded: at most {max_hz:g} of the newest messages a second are taken; the rest is dropped"
        )
        structlog.get_logger().warning("too many messages", reason=sentence)

    def _taken(self) -> tuple[str, bytes] | None:
        """Key and payload of the oldest message kept, of copies the first; None without one, or for copies alone."""
        for _ in range(self._channel.depth):  # no more, however fast copies come
            sample = self._subscriber.try_recv()
            if sample is None:
                return None
            payload = sample.payload.to_bytes()
            if not self._is_copy(payload):
                return str(sample.key_expr), payload
        return None

    def _is_copy(self, payload: bytes) -> bool:
        return self._copies is not None and self._copies.is_copy(payload)

    def _decode(self, key: str, payload: bytes) -> M:
        try:
            message = decode(payload, self._channel.message, self._channel.max_bytes)
        except MessageError:
            self._tap(key, payload, sent=False, refused=True)
            raise
        self._tap(key, payload, sent=False)
        return message
