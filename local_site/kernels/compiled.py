"""Compiling of inner loops: over a few thousand pairs of pixel and part, arrays would cost many times as much."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """The function as machine code, kept on disk between runs; divisions by zero give infinities, as in arrays."""
    return cast(Function, numba.njit(cache=True, error_model="numpy")(function))
