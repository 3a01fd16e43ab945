"""Time that the host takes away: the worst quarter of a second counts, not what was stolen before."""

import itertools
import time
from pathlib import Path

import pytest

from lab.stage import stolen_time
from lab.stage.stolen_time import StolenTime


def test_the_worst_moment_is_told() -> None:
    counts = itertools.chain([5000.0] * 3, itertools.repeat(5100.0))
    with StolenTime(cores=2, read=lambda: next(counts)) as stolen:
        time.sleep(0.4)
    assert stolen.worst == pytest.approx(100.0 / 500.0)


def test_where_nothing_is_stolen_it_is_0() -> None:
    with StolenTime(cores=2, read=lambda: 7.0) as stolen:
        time.sleep(0.1)
    assert stolen.worst == 0.0


def test_linux_counts_it_for_all_cores(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    stat = tmp_path / "stat"
    monkeypatch.setattr(stolen_time, "STAT", stat)
    stat.write_text("cpu  1 2 3 4 5 6 7 89 0 0\ncpu0 1 2 3 4 5 6 7 1 0 0\n")
    assert stolen_time.stolen_ms() == 890.0
    stat.write_text("cpu  1 2 3 4\n")
    assert stolen_time.stolen_ms() == 0.0
