"""Threads that pass on what channels bring, each until its link is closed, and that are then waited for."""

import threading
from collections.abc import Callable
from typing import TypeVar

from common.link.pubsub import Latest
from common.messages.base import Message

M = TypeVar("M", bound=Message)

JOIN_S = 2.0  # each ends at once with its link


class ChannelFeeds:
    """A thread for each channel; its owner closes their links, and then joins them."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def add(self, latest: Latest[M], take: Callable[[M, int], None]) -> None:
        """Pass each message of a channel, with its time of arrival (ns), to `take` from now on."""
        thread = threading.Thread(target=latest.feed, args=(take,), name="listen", daemon=True)
        thread.start()
        self._threads.append(thread)

    def join(self) -> None:
        """Wait for the threads once the links are closed: one that wakes while Python ends aborts the process."""
        for thread in self._threads:
            thread.join(JOIN_S)
