"""Under which topic a message is kept that passed the wire: its key, with its kind and the protocol's version."""

import re
from functools import lru_cache

from common.link.channels import CHANNELS, PROCEDURES, Keyed
from common.messages.base import PROTOCOL_VERSION
from common.recording.topics import Topic, wire_topic

CHUNK = r"[^/]+"
ANSWER = "/reply"
UNKNOWN = "unknown"
MOST_KEYS = 1024  # that are remembered: of 32 operators some 400, and without a list anybody invents names


@lru_cache(MOST_KEYS)
def topic_of(key: str, *, sent: bool) -> Topic:
    """The topic of messages on this key, sent or received by the host that records.

    The replies of a procedure, sent by the site that answers, have a topic of their own.
    """
    direction = "sent" if sent else "received"
    for channel in CHANNELS:
        if _matches(channel, key):
            return wire_topic(key, channel.message.__name__, PROTOCOL_VERSION, direction=direction)
    for procedure in PROCEDURES:
        if _matches(procedure, key):
            kind = procedure.reply if sent else procedure.request
            return wire_topic(key + ANSWER * sent, kind.__name__, PROTOCOL_VERSION, direction=direction)
    return wire_topic(key, UNKNOWN, PROTOCOL_VERSION, direction=direction)


def _matches(keyed: Keyed, key: str) -> bool:
    pattern = "".join(CHUNK if part.startswith("{") else re.escape(part) for part in re.split(r"(\{\w+\})", keyed.key))
    return re.fullmatch(pattern, key) is not None
