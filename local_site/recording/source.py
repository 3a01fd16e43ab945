"""Hears, as another program of the operator's host, what passes between the sites, byte for byte."""

import threading
import time
from collections.abc import Iterator
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import NamedTuple, Self

from common.link.channels import HAND, PREVIEW, STATE, Channel
from common.link.endpoints import from_this_host
from common.link.transport import open_link
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig

JOIN_S = 0.5
MOST_WAITING = 20_000  # messages; a recorder that stands still for minutes must not fill the memory


class HeardMessage(NamedTuple):
    """A message as it was heard at `t_ns`; `sent` by the local site, or received by it."""

    key: str
    t_ns: int
    sent: bool
    payload: bytes


class OperatorSource:
    """Listens while its block lasts; the operator's views are only made while somebody listens to them."""

    def __init__(self, config: LocalConfig) -> None:
        self._queue: SimpleQueue[HeardMessage] = SimpleQueue()
        self.lost = 0
        self._state_key = STATE.key_for(config.cell)
        links, cell, name = config.links, config.cell, config.authority.name
        connect = (from_this_host(links.listen), links.remote)
        self.link = open_link(connect=connect, security=links, tap=self._heard)
        self._threads = [
            self._listen(HAND, cell, name),
            self._listen(STATE, cell, name),
        ]
        if config.record.operator_pictures:
            self._threads += [self._listen(PREVIEW, cell, name, view) for view in CAMERAS]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.link.close()
        for thread in self._threads:
            thread.join(JOIN_S)

    def take(self) -> Iterator[HeardMessage]:
        """What has been heard since the last call."""
        for _ in range(self._queue.qsize()):
            try:
                yield self._queue.get_nowait()
            except Empty:
                return

    def _listen(self, channel: Channel, cell: str, operator: str, view: str = "*") -> threading.Thread:  # type: ignore[type-arg]  # of any message
        latest = self.link.latest(channel, cell, view, operator=operator)
        thread = threading.Thread(target=latest.feed, args=(lambda _message, _t_ns: None,), daemon=True)
        thread.start()
        return thread

    def _heard(self, key: str, payload: bytes, *, sent: bool) -> None:
        if sent:
            return  # the recorder's own notice
        if self._queue.qsize() >= MOST_WAITING:
            self.lost += 1
            return
        self._queue.put(HeardMessage(key, time.monotonic_ns(), key != self._state_key, payload))
