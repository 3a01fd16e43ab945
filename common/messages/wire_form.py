"""A message as it travels: structs as arrays, vectors as packed numbers, text cut to what a receiver accepts; and back.

Size counts where packets get lost: the congestion control of QUIC may then send no more than two per round trip.
"""

import math
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any

from msgspec import inspect

from common.errors import MessageError
from common.messages.base import Message
from common.text import cut

UNNAMED = "?"  # where a name is empty
SINGLE, DOUBLE = "f", "d"  # formats of struct, both little-endian

Convert = Callable[[Any], Any]
Numbers = tuple[float, ...]

LEAST_M, STEP = 1e-5, 0.045  # 0.01 mm to 1 m; a step is 4.6 %
STEPS, WHOLE = 255, 127  # of a standard deviation, of a correlation of 1
FORMAT = "<3B3b"


def pack_covariance(covariance: Numbers) -> bytes:
    """Of xx, xy, xz, yy, yz, zz in m²: three standard deviations on a logarithmic scale, three correlations.

    MessageError where it is not finite or a variance is negative.
    """
    xx, xy, xz, yy, yz, zz = covariance
    if not all(map(math.isfinite, covariance)):
        raise MessageError("not_finite", "a covariance is not finite")
    if min(xx, yy, zz) < 0:
        raise MessageError("invalid", "a variance is negative")
    x, y, z = (math.sqrt(variance) for variance in (xx, yy, zz))
    correlations = _correlation(xy, x * y), _correlation(xz, x * z), _correlation(yz, y * z)
    return struct.pack(FORMAT, *map(_steps, (x, y, z)), *correlations)


def unpack_covariance(packed: object) -> Numbers:
    """To half a step of each deviation, and to half a percent of the correlations; MessageError for anything else."""
    if not isinstance(packed, bytes) or len(packed) != struct.calcsize(FORMAT):
        raise MessageError("invalid", f"a covariance has {struct.calcsize(FORMAT)} bytes, not {str(packed)[:20]}")
    *steps, xy, xz, yz = struct.unpack(FORMAT, packed)
    if min(xy, xz, yz) < -WHOLE:
        raise MessageError("invalid", "a correlation is less than -1")
    x, y, z = (LEAST_M * math.exp(STEP * step) for step in steps)
    return x * x, x * y * xy / WHOLE, x * z * xz / WHOLE, y * y, y * z * yz / WHOLE, z * z


def _steps(deviation_m: float) -> int:
    if deviation_m <= LEAST_M:
        return 0
    return min(STEPS, round(math.log(deviation_m / LEAST_M) / STEP))


def _correlation(covariance: float, product: float) -> int:
    return round(max(-WHOLE, min(WHOLE, WHOLE * covariance / product))) if product > 0 else 0


@dataclass(frozen=True, slots=True)
class WireForm:
    """The wire form of one type's values: `pack` gives what MessagePack holds, `unpack` what msgspec validates.

    `unpack` raises MessageError for a wrong shape, and leaves types and bounds to msgspec.
    """

    pack: Convert
    unpack: Convert


@cache
def wire_form(message: type[Message]) -> WireForm:
    """The form of a kind of message: an array of its fields."""
    return _form(inspect.type_info(message))


def _form(kind: inspect.Type) -> WireForm:
    match kind:
        case inspect.Metadata(extra={"sent_as": "covariance"}):
            form = WireForm(pack_covariance, unpack_covariance)
        case inspect.Metadata(extra={"sent_as": "single precision"}):
            form = _numbers(SINGLE)
        case inspect.TupleType(item_types=(item, *_)) | inspect.VarTupleType(item_type=item):
            form = _numbers(DOUBLE) if isinstance(item, inspect.FloatType) else _items(_form(item))
        case inspect.FloatType():
            form = WireForm(_finite, lambda value: _finite(value) if isinstance(value, float) else value)
        case inspect.StrType(max_length=int(most), min_length=least):
            form = WireForm(lambda text: cut(text, most) or (UNNAMED if least else ""), _same)
        case inspect.EnumType(cls=choices):
            form = _choice(tuple(choices))
        case inspect.StructType(fields=fields):
            form = _struct([(field.name, _form(field.type)) for field in fields])
        case inspect.DictType(key_type=key, value_type=item):
            form = _table(_form(key), _form(item))
        case inspect.UnionType(types=kinds):
            form = _optional(next(_form(one) for one in kinds if not isinstance(one, inspect.NoneType)))
        case _:
            form = WireForm(_same, _same)
    return form


def _numbers(precision: str) -> WireForm:
    """The numbers of a vector; MessageError for one that is not finite."""
    size = struct.calcsize(precision)

    def pack(values: Sequence[float]) -> bytes:
        try:
            return struct.pack(f"<{len(values)}{precision}", *map(_finite, values))
        except OverflowError:
            raise MessageError("not_finite", "a number is too large") from None

    def unpack(packed: Any) -> tuple[float, ...]:
        if not isinstance(packed, bytes) or len(packed) % size:
            raise MessageError("invalid", f"a vector is packed in {size} bytes a number, not {str(packed)[:20]}")
        return tuple(map(_finite, struct.unpack(f"<{len(packed) // size}{precision}", packed)))

    return WireForm(pack, unpack)


def _items(form: WireForm) -> WireForm:
    return WireForm(lambda items: list(map(form.pack, items)), lambda items: tuple(map(form.unpack, _array(items))))


def _struct(fields: Sequence[tuple[str, WireForm]]) -> WireForm:
    def pack(value: Any) -> list[Any]:
        return [form.pack(getattr(value, name)) for name, form in fields]

    def unpack(items: Any) -> dict[str, Any]:
        if len(_array(items)) != len(fields):
            raise MessageError("invalid", f"{len(items)} fields instead of {len(fields)}")
        return {name: form.unpack(item) for (name, form), item in zip(fields, items, strict=True)}

    return WireForm(pack, unpack)


def _choice(choices: tuple[Enum, ...]) -> WireForm:
    numbers = {choice: number for number, choice in enumerate(choices)}

    def unpack(number: Any) -> Enum:
        if type(number) is not int or not 0 <= number < len(choices):
            raise MessageError("invalid", f"{str(number)[:20]} is not the number of one of {len(choices)} choices")
        return choices[number]

    return WireForm(numbers.__getitem__, unpack)


def _table(keys: WireForm, values: WireForm) -> WireForm:
    def unpack(table: Any) -> dict[Any, Any]:
        if not isinstance(table, dict):
            raise MessageError("invalid", f"a map, not {type(table).__name__}")
        return {keys.unpack(key): values.unpack(value) for key, value in table.items()}

    return WireForm(lambda table: {keys.pack(key): values.pack(value) for key, value in table.items()}, unpack)


def _optional(form: WireForm) -> WireForm:
    return WireForm(
        lambda value: None if value is None else form.pack(value),
        lambda value: None if value is None else form.unpack(value),
    )


def _finite(value: float) -> float:
    if not math.isfinite(value):
        raise MessageError("not_finite", "a number is not finite")
    return value


def _array(items: Any) -> Sequence[Any]:
    if not isinstance(items, tuple):
        raise MessageError("invalid", f"an array, not {type(items).__name__}")
    return items


def _same(value: Any) -> Any:
    return value
