"""The codec: golden bytes hold, anything else is a counted rejection."""

from pathlib import Path

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

import tests.common.messages.golden_examples as golden
from common.errors import MessageError
from common.link.channels import HAND
from common.messages.codec import decode, encode
from common.messages.hand import HandArm
from common.messages.requests import EngagementAction, EngagementRequest

LARGE = 1_000_000


@pytest.mark.parametrize("name", golden.VALID)
def test_golden_bytes_are_what_the_encoder_writes(name: str) -> None:
    assert encode(golden.VALID[name]) == (golden.GOLDEN / "valid" / f"{name}.msgpack").read_bytes()


@pytest.mark.parametrize("name", golden.VALID)
def test_golden_bytes_decode_to_the_message(name: str) -> None:
    message = golden.VALID[name]
    assert decode((golden.GOLDEN / "valid" / f"{name}.msgpack").read_bytes(), type(message), LARGE) == message


@pytest.mark.parametrize("path", sorted((golden.GOLDEN / "broken").glob("*.msgpack")), ids=lambda path: path.stem)
def test_broken_bytes_are_refused_with_their_reason(path: Path) -> None:
    with pytest.raises(MessageError) as caught:
        decode(path.read_bytes(), HandArm, HAND.max_bytes)
    assert caught.value.reason == path.stem.partition(".")[0]


def test_every_broken_example_is_on_disk() -> None:
    assert {p.stem for p in (golden.GOLDEN / "broken").glob("*.msgpack")} == set(golden.broken())


@given(st.binary(max_size=300))
def test_random_bytes_are_refused_and_never_raise_anything_else(payload: bytes) -> None:
    with pytest.raises(MessageError):
        decode(payload, HandArm, HAND.max_bytes)


def outcome(payload: bytes) -> str:
    try:
        decode(payload, HandArm, HAND.max_bytes)
    except MessageError as error:
        return error.reason
    return "valid"


@given(st.integers(0, len(encode(golden.HAND)) - 1), st.integers(0, 255))
def test_a_changed_byte_gives_a_valid_message_or_a_rejection(position: int, value: int) -> None:
    payload = bytearray(encode(golden.HAND))
    payload[position] = value
    assert outcome(bytes(payload)) in {"valid", "malformed", "version", "invalid", "not_finite"}


def test_a_stop_among_the_other_requests_is_refused_since_it_could_be_displaced_there() -> None:
    fields = msgpack.unpackb(encode(golden.RESET))
    fields[-2] = list(EngagementAction).index(EngagementAction.STOP)
    with pytest.raises(MessageError, match="a stop is a StopRequest"):
        decode(msgpack.packb(fields), EngagementRequest, LARGE)


def test_encoding_refuses_what_is_not_finite() -> None:
    sample = HandArm(
        **{f: getattr(golden.HAND, f) for f in HandArm.__struct_fields__} | {"wrist": (0.0, float("inf"), 0.0)}
    )
    with pytest.raises(MessageError, match="not_finite"):
        encode(sample)
