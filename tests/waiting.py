"""How tests wait for what happens in another thread or process."""

import time
from collections.abc import Callable

PATIENCE_S = 30.0  # on a busy machine; nothing is judged by how long it takes


def until(is_so: Callable[[], object], what: str = "it", seconds: float = PATIENCE_S) -> None:
    """Wait until something is so; an AssertionError that names it where that takes longer."""
    deadline = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < deadline, f"waited {seconds:g} s in vain for {what}"
        time.sleep(0.005)
