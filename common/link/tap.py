"""The tap of a link, which sees each message byte for byte as it passes, for a recorder; most links have none."""

from typing import Protocol


class MessageTap(Protocol):
    """Called with the key and the bytes of each message, `sent` by this side or received; it must never wait.

    It is `refused` where it was received on a channel and is no message of that channel.
    """

    def __call__(self, key: str, payload: bytes, *, sent: bool, refused: bool = False) -> None: ...


def untapped(key: str, payload: bytes, *, sent: bool, refused: bool = False) -> None:
    """Look at nothing, for a link without a tap."""
