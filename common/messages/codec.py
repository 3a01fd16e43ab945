"""Messages to bytes and back: msgpack on the wire, types checked by msgspec, all numbers finite, else MessageError."""

from typing import Any, TypeVar

import msgpack
import msgspec

from common.errors import MessageError
from common.messages.base import PROTOCOL_VERSION, Message
from common.messages.wire_form import wire_form

M = TypeVar("M", bound=Message)

MAX_ITEMS = 64
MAX_TEXT_BYTES = 4096


def encode(message: Message) -> bytes:
    """Pack the protocol version and the message's fields as one array in msgpack.

    Text is cut to what `decode` accepts; MessageError for a number that is not finite.
    """
    packed: bytes = msgpack.packb((PROTOCOL_VERSION, *wire_form(type(message)).pack(message)), use_bin_type=True)
    return packed


def decode(payload: bytes, message: type[M], max_bytes: int) -> M:
    """Read the message in `payload`; MessageError, with a reason for counting, for anything else.

    The size is capped before decoding; versions other than ours, unknown or missing fields, wrong types and numbers
    that are not finite are refused.
    """
    if len(payload) > max_bytes:
        raise MessageError("oversized", f"{len(payload)} bytes, at most {max_bytes} for {message.__name__}")
    items = _unpack(payload, max_bytes)
    if not isinstance(items, tuple) or not items:
        raise MessageError("malformed", f"a {message.__name__} is an array, not {type(items).__name__}")
    version, fields = items[0], items[1:]
    if type(version) is not int or version != PROTOCOL_VERSION:
        raise MessageError(
            "version", f"version {str(version)[:20]}, this side speaks {PROTOCOL_VERSION}: install the same release"
        )
    try:
        return msgspec.convert(wire_form(message).unpack(fields), message)
    except msgspec.ValidationError as error:
        raise MessageError("invalid", f"{message.__name__}: {error}") from error


def _unpack(payload: bytes, max_bytes: int) -> Any:
    try:
        return msgpack.unpackb(
            payload,
            raw=False,
            strict_map_key=True,
            use_list=False,
            max_map_len=MAX_ITEMS,
            max_array_len=MAX_ITEMS,
            max_str_len=MAX_TEXT_BYTES,
            max_bin_len=max_bytes,
            max_ext_len=0,
        )
    except (ValueError, TypeError, RecursionError, msgpack.UnpackException) as error:
        raise MessageError("malformed", str(error)[:200] or type(error).__name__) from error
