"""Whatever a driver, a camera or an operator says: what is sent can be received."""

from enum import Enum
from typing import Any

import msgspec
import pytest

from common.link.channels import CHANNELS, PROCEDURES
from common.messages.base import Message
from common.messages.codec import decode, encode
from tests.common.messages.golden_examples import VALID

MANY_BYTES = 1_000_000
WIDE = "\N{ROBOT FACE}"  # four bytes of UTF-8
LIMITS = {c.message: c.max_bytes for c in CHANNELS} | {p.request: p.max_bytes for p in PROCEDURES}
LIMITS |= {p.reply: p.max_bytes for p in PROCEDURES}


def saying(value: Any, text: str) -> Any:
    """The same message with another text wherever it holds some."""
    if isinstance(value, str):
        return value if isinstance(value, Enum) else text
    if isinstance(value, msgspec.Struct):
        fields = {name: saying(getattr(value, name), text) for name in value.__struct_fields__}
        return type(value)(**fields)
    if isinstance(value, tuple):
        return tuple(saying(item, text) for item in value)
    if isinstance(value, dict):
        return {saying(name, text): saying(item, text) for name, item in value.items()}
    return value


@pytest.mark.parametrize("text", ["x" * 401, "x" * 100_000, "\ud800 no character", "", "\x00\x1b[2J", WIDE * 401])
@pytest.mark.parametrize("name", VALID)
def test_any_text_can_be_sent_and_received(name: str, text: str) -> None:
    message = saying(VALID[name], text)
    received = decode(encode(message), type(message), MANY_BYTES)
    assert type(received) is type(message)


@pytest.mark.parametrize("name", VALID)
def test_the_longest_text_fits_into_its_channel(name: str) -> None:
    message = saying(VALID[name], WIDE * 1000)
    assert len(encode(message)) <= LIMITS[type(message)]


def test_numbers_and_short_texts_are_sent_as_they_are() -> None:
    for message in VALID.values():
        assert decode(encode(message), type(message), MANY_BYTES) == message


def test_all_messages_are_among_the_examples() -> None:
    assert set(LIMITS) <= {type(message) for message in VALID.values()}
    assert all(issubclass(message, Message) for message in LIMITS)
