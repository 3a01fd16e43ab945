"""How long a process waits for its processor: the longest turn of the last half second counts."""

from pathlib import Path

import pytest

from common.clock import NS_PER_MS
from common.process.processor_wait import ProcessorWait, QueuedTime


def test_the_longest_wait_of_the_last_half_second_counts() -> None:
    wait = ProcessorWait()
    assert wait.longest_ms(0) == 0.0
    for k, queued_ms in enumerate((7000, 7000, 7120, 7123)):
        wait.turn(queued_ms * NS_PER_MS, 20 * k * NS_PER_MS)
    assert wait.longest_ms(60 * NS_PER_MS) == pytest.approx(120.0)
    assert wait.longest_ms(539 * NS_PER_MS) == pytest.approx(120.0)
    assert wait.longest_ms(541 * NS_PER_MS) == pytest.approx(3.0)
    assert wait.longest_ms(600 * NS_PER_MS) == 0.0


def test_the_kernels_count_is_read_anew_each_time(tmp_path: Path) -> None:
    counts = tmp_path / "schedstat"
    counts.write_text("123456 789000000 12\n", encoding="ascii")
    queued = QueuedTime(counts)
    assert queued.read_ns() == 789 * NS_PER_MS
    counts.write_text("123456 790000000 13\n", encoding="ascii")
    assert queued.read_ns() == 790 * NS_PER_MS


def test_a_kernel_that_does_not_count_says_nothing(tmp_path: Path) -> None:
    assert QueuedTime(tmp_path / "schedstat").read_ns() == 0
