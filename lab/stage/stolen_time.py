"""How much processor time this machine's host gives to others while something is measured, as Linux counts it."""

import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread
from typing import Self

STAT = Path("/proc/stat")
STOLEN_COLUMN = 8  # of the line of all cores: user, nice, system, idle, iowait, irq, softirq, steal
TICK_MS = 10.0  # in which /proc/stat counts
EVERY_S, WINDOW_S = 0.05, 0.25


def stolen_ms() -> float:
    """Read how long all cores together have waited for the host since the start, ms; 0 where nothing counts it."""
    fields = STAT.read_text(encoding="ascii").split("\n", 1)[0].split()
    return TICK_MS * int(fields[STOLEN_COLUMN]) if len(fields) > STOLEN_COLUMN else 0.0


class StolenTime:
    """Watches while its block lasts; `worst` is the greatest share of all cores that was stolen within 0.25 s."""

    def __init__(self, cores: int, read: Callable[[], float] = stolen_ms) -> None:
        self._window_ms, self._read = 1e3 * WINDOW_S * cores, read
        self._ended, self._thread = Event(), Thread(target=self._watch, name="stolen", daemon=True)
        self.worst = 0.0

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()

    def _watch(self) -> None:
        seen = deque([(time.monotonic(), self._read())])
        while not self._ended.wait(EVERY_S):
            now = time.monotonic(), self._read()
            seen.append(now)
            while now[0] - seen[0][0] > WINDOW_S:
                seen.popleft()
            self.worst = max(self.worst, (now[1] - seen[0][1]) / self._window_ms)
