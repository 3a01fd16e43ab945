"""How memory, descriptors and threads of a process change over time; pure but for reading /proc."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from lab.stage.processes import memory_mb

S_PER_HOUR = 3600.0
SHARE = 5  # the first, the middle and the last fifth are compared


@dataclass(frozen=True, slots=True)
class Usage:
    """What a process holds at a time, s: resident memory, open descriptors, threads."""

    t_s: float
    memory_mb: float
    descriptors: int
    threads: int


def usage_of(pid: int, t_s: float) -> Usage | None:
    """What a process holds now; None where it has just ended."""
    process = Path(f"/proc/{pid}")
    try:
        counts = (sum(1 for _ in (process / part).iterdir()) for part in ("fd", "task"))
        return Usage(t_s, memory_mb(pid), *counts)
    except (OSError, StopIteration):
        return None


def growth(usages: Sequence[Usage]) -> dict[str, float]:
    """Medians of the first, the middle and the last fifth, and the memory's slope between the latter two, MB an hour.

    A median passes over what comes and goes, and buffers are full by the middle; what only grows is in the difference.
    ValueError for fewer than five.
    """
    part = len(usages) // SHARE
    if part == 0:
        raise ValueError(f"growth needs at least {SHARE} usages, there are {len(usages)}")
    middle_from = (len(usages) - part) // 2
    first, middle, last = (_medians(usages[k : k + part]) for k in (0, middle_from, len(usages) - part))
    hours = (last["t_s"] - middle["t_s"]) / S_PER_HOUR
    figures = {
        f"{name}_{when}": ends[name]
        for name in ("mb", "fds", "threads")
        for when, ends in (("first", first), ("middle", middle), ("last", last))
    }
    return figures | {"mb_per_hour": (last["mb"] - middle["mb"]) / hours}


def _medians(usages: Sequence[Usage]) -> dict[str, float]:
    rows = np.array([(each.t_s, each.memory_mb, each.descriptors, each.threads) for each in usages])
    return dict(zip(("t_s", "mb", "fds", "threads"), np.median(rows, axis=0).tolist(), strict=True))
