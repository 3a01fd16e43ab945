"""Bytes to message and back: msgpack on the wire, types checked by msgspec, everything finite, or MessageError."""

import math
import re
from typing import Any, TypeVar

import msgpack
import msgspec

from common.errors import MessageError
from common.messages.base import PROTOCOL_VERSION, Message

M = TypeVar("M", bound=Message)

# In msgpack every infinity and NaN is a 0xca or 0xcb with an exponent of ones; other bytes may look the same.
MAYBE_NOT_FINITE = re.compile(rb"\xcb[\x7f\xff][\xf0-\xff]|\xca[\x7f\xff][\x80-\xff]")
MAX_ITEMS = 64
MAX_TEXT_BYTES = 4096


def encode(message: Message) -> bytes:
    """The message as msgpack bytes; MessageError when a number in it is not finite."""
    fields = msgspec.to_builtins(message, builtin_types=(bytes,))
    _check_finite(fields)
    packed: bytes = msgpack.packb(fields, use_bin_type=True)
    return packed


def decode(payload: bytes, message: type[M], max_bytes: int) -> M:
    """The message in `payload`; MessageError, with a reason for counting, for anything else.

    The size is capped before decoding; versions other than ours, unknown or missing fields, wrong types and numbers
    that are not finite are refused.
    """
    if len(payload) > max_bytes:
        raise MessageError("oversized", f"{len(payload)} bytes, at most {max_bytes} for {message.__name__}")
    fields = _unpack(payload, max_bytes)
    if not isinstance(fields, dict):
        raise MessageError("malformed", f"a {message.__name__} is a map, not {type(fields).__name__}")
    version = fields.get("version")
    if type(version) is not int or version != PROTOCOL_VERSION:
        raise MessageError(
            "version", f"version {str(version)[:20]}, this side speaks {PROTOCOL_VERSION}: install the same release"
        )
    if MAYBE_NOT_FINITE.search(payload):
        _check_finite(fields)
    try:
        return msgspec.convert(fields, message)
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


def _check_finite(value: Any) -> None:
    if isinstance(value, float):
        if not math.isfinite(value):
            raise MessageError("not_finite", "a number is not finite")
    elif isinstance(value, dict):
        for item in value.values():
            _check_finite(item)
    elif isinstance(value, list | tuple):
        for item in value:
            _check_finite(item)
