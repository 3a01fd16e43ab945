"""Compiling of inner loops: over a few thousand pairs of pixel and part, arrays would cost many times as much."""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

from local_site.kernels.code_cache import LOCATORS, CodeCache

Function = TypeVar("Function", bound=Callable[..., object])

numba.config.CACHE_LOCATOR_CLASSES = LOCATORS  # type: ignore[attr-defined]  # made from the environment


def compiled(function: Function) -> Function:
    """The function as machine code, kept on disk between runs; divisions by zero give infinities, as in arrays."""
    dispatcher = numba.njit(error_model="numpy")(function)
    dispatcher._cache = CodeCache(function)  # type: ignore[attr-defined, no-untyped-call]  # numba itself has no room for another
    return cast(Function, dispatcher)
