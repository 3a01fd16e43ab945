"""Probes of the link between an operator's host and the remote site, and their echoes; frozen structs."""

from typing import Annotated

import msgspec

from common.messages.base import Count, Message

MOST_PADDING = 16_000
ROOM_BYTES = 512  # of a message for all but its padding
Padding = Annotated[bytes, msgspec.Meta(max_length=MOST_PADDING)]


class Probe(Message, frozen=True):
    """One of a sequence of probes: `session` is a random number of the sequence, `seq` rises by one from 0.

    `padding` loads the link on the way there, `echo_bytes` is how much padding the echo is to have.
    """

    session: Count
    seq: Count
    sent_ns: Count
    echo_bytes: Annotated[int, msgspec.Meta(ge=0, le=MOST_PADDING)] = 0
    padding: Padding = b""


class ProbeEcho(Message, frozen=True):
    """The echo of one probe: when it was received and answered, by the remote site's clock.

    Every probe that comes is echoed, so `received` counts the probes that have come and the echoes that were sent, with
    this one. With `refused` the echo has no padding: the arm is engaged, and its link is not to be loaded.
    """

    session: Count
    seq: Count
    sent_ns: Count
    received_ns: Count
    answered_ns: Count
    received: Count
    refused: bool = False
    padding: Padding = b""
