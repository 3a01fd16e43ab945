"""The recorder's end of the site's memory: attached while the site lives, its rings read, its orders taken."""

from collections.abc import Iterator
from pathlib import Path

import structlog

from common.clock import NS_PER_MS
from common.errors import ProcessError
from common.messages.recording import RecordingState
from remote_site.recording.memory import RecordingMemory, stop_waiting, wait_for_site
from remote_site.recording.records import ENCODER, KEPT, ORDERS, Kept, RecordOrder
from remote_site.shared_ring import RingReader

LOOK_NS = 300 * NS_PER_MS
MOST_AT_ONCE = 5000  # records: a step must not outlast the recorder's beat


class SiteAttachment:
    """Finds the site's memory when it appears, beats while it is there, and lets go of it when the site has ended."""

    def __init__(self, place: Path) -> None:
        self._place, self._waits = place, wait_for_site(place)
        self._memory: RecordingMemory | None = None
        self._readers: tuple[RingReader, ...] = ()
        self._orders: RingReader | None = None
        self._looked_ns = -LOOK_NS
        self._before = 0
        self._refused = ""

    def close(self) -> None:
        """Wait for no site any more."""
        if self._waits is not None:
            stop_waiting(self._waits)
            self._waits = None

    @property
    def lost(self) -> int:
        """The records that were overwritten before they were taken, since the recording began."""
        return sum(reader.lost for reader in self._readers) - self._before

    def attend(self, now_ns: int) -> bool:
        """Beat; whether a site is there. What it left before it ended can still be taken once."""
        if now_ns - self._looked_ns >= LOOK_NS:
            self._looked_ns = now_ns
            self._look()
        self.beat(now_ns)
        return self._memory is not None

    def beat(self, now_ns: int) -> None:
        """Show the site that this recorder lives; may be called from any thread."""
        memory = self._memory
        if memory is not None:
            memory.beat(now_ns)

    def orders(self) -> Iterator[RecordOrder]:
        """Yield what the lease's holder has asked for."""
        if self._orders is not None:
            for data in iter(self._orders.take, None):
                yield ORDERS.decode(data)

    def records(self) -> Iterator[Kept]:
        """Yield what control and video have left since the last call."""
        for reader in self._readers:
            for _ in range(MOST_AT_ONCE):
                data = reader.take()
                if data is None:
                    break
                yield KEPT.decode(data)

    def skip(self) -> None:
        """Leave out what came until now, and count losses from now on: a recording begins that was asked for."""
        for _ in self.records():
            pass
        self._before += self.lost

    def tell(self, state: RecordingState) -> None:
        """Show the site what the recorder does."""
        if self._memory is not None:
            self._memory.status.write(ENCODER.encode(state))

    def _look(self) -> None:
        if self._memory is not None and self._memory.is_left():
            self._memory.close()
            self._memory, self._orders = None, None
            return
        if self._memory is None:
            self._attach()

    def _attach(self) -> None:
        try:
            self._memory = RecordingMemory.attach(self._place)
        except ProcessError as error:
            if str(error) != self._refused:
                self._refused = str(error)
                structlog.get_logger().error("cannot record", reason=str(error))
            return
        if self._memory is not None:
            memory = self._memory
            first, self._before = memory.take_over(), 0
            self._readers = tuple(RingReader(ring, from_first=first) for ring in (memory.ticks, memory.pictures))
            self._orders = RingReader(memory.requests)
