"""The alternatives of a key's type, and the only values that it allows, if it names them; pure."""

from collections.abc import Iterator
from enum import Enum
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin


def allowed_values(expected: Any) -> list[Any]:
    """List the values that the enums and Literals of a type allow; none for any other type."""
    return [value for part in alternatives(expected) for value in _values(part)]


def alternatives(expected: Any) -> Iterator[Any]:
    """A type's alternatives, without what limits them."""
    if get_origin(expected) is Annotated:
        yield from alternatives(get_args(expected)[0])
    elif isinstance(expected, UnionType) or get_origin(expected) is Union:
        for part in get_args(expected):
            yield from alternatives(part)
    else:
        yield expected


def _values(part: Any) -> list[Any]:
    if isinstance(part, type) and issubclass(part, Enum):
        return [member.value for member in part]
    return list(get_args(part)) if get_origin(part) is Literal else []
