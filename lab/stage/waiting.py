"""How one waits for what happens in another thread or process."""

import time
from collections.abc import Callable

from common.errors import ProcessError

PATIENCE_S = 30.0  # on a busy machine; nothing is judged by how long it takes
POLL_S = 0.005


def until(
    is_so: Callable[[], object],
    what: str = "it",
    seconds: float = PATIENCE_S,
    told: Callable[[], object] = lambda: "",
) -> None:
    """Wait until something is so; ProcessError that names it, and adds what is `told`, where that takes longer."""
    deadline_s = time.monotonic() + seconds
    while not is_so():
        if time.monotonic() > deadline_s:
            words = told()
            raise ProcessError(f"waited {seconds:g} s in vain for {what}" + (f": {words}" if words else ""))
        time.sleep(POLL_S)
