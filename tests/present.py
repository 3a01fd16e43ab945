"""What a test knows to be there."""

from typing import TypeVar

T = TypeVar("T")


def present(found: T | None) -> T:
    """Return what was found; fail where that is nothing."""
    assert found is not None
    return found
