"""Echoes the probes by which an operator's host measures the link, bounded so that they disturb no engagement."""

from collections.abc import Callable, Sequence

from common.clock import Clock
from common.errors import MessageError
from common.link.channels import ECHO, LOAD, LOAD_ECHO, PROBE, Channel
from common.link.pubsub import Latest, Publisher
from common.link.transport import Link
from common.messages.probe import ROOM_BYTES, Probe, ProbeEcho

PER_TICK = 2  # of a channel, of all operators together
MOST_ECHOED = 32  # operators


class EchoChannel:
    """One channel of probes with that of its echoes."""

    def __init__(
        self, link: Link, cell: str, operators: Sequence[str], channels: tuple[Channel[Probe], Channel[ProbeEcho]]
    ) -> None:
        self._probe, self._echo = channels
        self._link, self._cell = link, cell
        self._sources = [link.latest(self._probe, cell, operator=name) for name in operators]
        self._first = 0
        self._publishers: dict[str, Publisher[ProbeEcho]] = {}
        self._received: dict[str, tuple[int, int]] = {}  # by operator: the sequence, and how many have come

    def poll(self, clock: Clock, refused: Callable[[MessageError], None], *, engaged: bool) -> None:
        """Echo what has come, PER_TICK at most; every operator's turn comes."""
        self._first += 1
        count = len(self._sources)
        left = PER_TICK
        for k in range(count):
            source = self._sources[(self._first + k) % count]
            while left and self._serve(source, clock, refused, engaged=engaged):
                left -= 1

    def _serve(
        self, source: Latest[Probe], clock: Clock, refused: Callable[[MessageError], None], *, engaged: bool
    ) -> bool:
        """Echo one probe of a source; False when none waits."""
        try:
            named = source.take_named()
        except MessageError as error:
            refused(error)
            return True
        if named is None:
            return False
        operator, probe = named
        publisher = self._publisher(operator)
        if publisher is not None:
            publisher.put(self._answer(operator, probe, clock, bars_load=engaged and self._probe is LOAD))
        return True

    def _answer(self, operator: str, probe: Probe, clock: Clock, *, bars_load: bool) -> ProbeEcho:
        received_ns = clock.now_ns()
        session, count = self._received.get(operator, (probe.session, 0))
        received = count + 1 if session == probe.session else 1
        self._received[operator] = probe.session, received
        return ProbeEcho(
            session=probe.session,
            seq=probe.seq,
            sent_ns=probe.sent_ns,
            received_ns=received_ns,
            answered_ns=clock.now_ns(),
            received=received,
            refused=bars_load,
            padding=b"" if bars_load else bytes(min(probe.echo_bytes, self._echo.max_bytes - ROOM_BYTES)),
        )

    def _publisher(self, operator: str) -> Publisher[ProbeEcho] | None:
        """Return what sends this operator's echoes; None for more names than a list can have."""
        if operator not in self._publishers and len(self._publishers) < MOST_ECHOED:
            self._publishers[operator] = self._link.publisher(self._echo, self._cell, operator=operator)
        return self._publishers.get(operator)


class ProbeServer:
    """Polled by the control loop after each command is written; while the arm is engaged it refuses to load its link.

    It echoes 500 probes a second at most and, of those that load the link, 64 Mbit/s.
    """

    def __init__(
        self,
        link: Link,
        cell: str,
        operators: Sequence[str],
        clock: Clock,
        refused: Callable[[MessageError], None],
    ) -> None:
        self._channels = [EchoChannel(link, cell, operators, pair) for pair in ((PROBE, ECHO), (LOAD, LOAD_ECHO))]
        self._clock, self._refused = clock, refused

    def poll(self, *, engaged: bool) -> None:
        """Echo what has come."""
        for channel in self._channels:
            channel.poll(self._clock, self._refused, engaged=engaged)
