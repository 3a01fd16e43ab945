"""Hears, as another program of the operator's host, what passes between the sites, byte for byte."""

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import NamedTuple, Self, TypeVar

from common.errors import MessageError
from common.link.channel_feeds import ChannelFeeds
from common.link.channels import HAND, PREVIEW, RECORD_ORDER, STATE, Channel
from common.link.endpoints import from_this_host
from common.link.pubsub import Latest
from common.link.transport import open_link
from common.messages.base import Message
from common.messages.requests import RecordRequest
from common.messages.video import VideoFrame
from common.process.log import RefusalLog
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig

M = TypeVar("M", bound=Message)

LOOK_S = 0.01
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
        self._cell, self._operator = config.cell, config.authority.name
        self._state_key = STATE.key_for(config.cell)
        self._refusals = RefusalLog("order refused")
        connect = (from_this_host(config.links.listen), config.links.remote)
        self.link = open_link(connect=connect, security=config.links, tap=self._heard)
        self._orders = self.link.latest(RECORD_ORDER, self._cell, operator=self._operator)
        self._views: HeardViews | None = None
        self._feeds = ChannelFeeds()
        self._empty(HAND)
        self._empty(STATE)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.hear_views(wanted=False)
        self.link.close()
        self._feeds.join()

    def take(self) -> Iterator[HeardMessage]:
        """Yield what has been heard since the last call."""
        for _ in range(self._queue.qsize()):
            try:
                yield self._queue.get_nowait()
            except Empty:
                return

    def orders(self) -> Iterator[RecordRequest]:
        """Yield what the operator has asked for since the last call."""
        for _ in range(self._orders.depth):
            try:
                order = self._orders.take()
            except MessageError as error:
                self._refusals.note(error)
                continue
            if order is None:
                return
            yield order

    def hear_views(self, *, wanted: bool) -> None:
        """Listen to the operator's views, or no more."""
        if wanted and self._views is None:
            named = [self.link.latest(PREVIEW, self._cell, view, operator=self._operator) for view in CAMERAS]
            self._views = HeardViews(named)
        elif self._views is not None and not wanted:
            self._views.close()
            self._views = None

    def _empty(self, channel: Channel[M]) -> None:
        """Take what comes of a channel: the link's tap has it."""
        latest = self.link.latest(channel, self._cell, operator=self._operator)
        self._feeds.add(latest, lambda _message, _t_ns: None)

    def _heard(self, key: str, payload: bytes, *, sent: bool, refused: bool = False) -> None:
        del refused  # it is kept all the same
        if sent:
            return  # the recorder's own notice
        if self._queue.qsize() >= MOST_WAITING:
            self.lost += 1
            return
        self._queue.put(HeardMessage(key, time.monotonic_ns(), key != self._state_key, payload))


class HeardViews:
    """Subscriptions that can be given up again: the thread that empties them never waits in one."""

    def __init__(self, views: Sequence[Latest[VideoFrame]]) -> None:
        self._views, self._ended = views, threading.Event()
        self._thread = threading.Thread(target=self._empty, name="views", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Hear no more of them."""
        self._ended.set()
        self._thread.join()
        for view in self._views:
            view.close()

    def _empty(self) -> None:
        while not self._ended.wait(LOOK_S):
            for view in self._views:
                with suppress(MessageError):
                    view.take()  # the link's tap has it
