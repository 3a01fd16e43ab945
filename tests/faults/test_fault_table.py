"""Every fault of the table on real processes: as promised, and within the limits in every command."""

import time

import pytest

from common.clock import NS_PER_MS
from common.errors import FarhandError
from tests.faults.conftest import Stage
from tests.faults.fault_rows import ROWS, Row
from tests.faults.trial import Outcome, Trial

SHARED_MACHINE_NS = 100 * NS_PER_MS  # a machine under tests may pause for this long; 'make faults' allows no pause


def play(row: Row, stage: Stage, pause_ns: int = 0) -> Outcome:
    """Play a row on the pair that it needs, and report what came of it."""
    begun, outcome = time.monotonic(), Outcome()
    try:
        trial = Trial(stage.pair_for(row), outcome, pause_ns)
        if row.engaged:
            trial.pair.engage()
        row.play(trial)
        trial.end()
    except (AssertionError, OSError, FarhandError) as error:
        outcome.failures.append(str(error))
    stage.report.add(row, outcome, time.monotonic() - begun)
    stage.settle(outcome)
    return outcome


@pytest.mark.faults
@pytest.mark.parametrize("row", sorted(ROWS, key=lambda row: row.settings), ids=lambda row: row.fault)
def test_full(row: Row, stage: Stage) -> None:
    outcome = play(row, stage)
    assert not outcome.failures, outcome


@pytest.mark.parametrize("row", [row for row in ROWS if row.quick], ids=lambda row: row.fault)
def test_shortened(row: Row, one_host: Stage) -> None:
    outcome = play(row, one_host, SHARED_MACHINE_NS)
    assert not outcome.failures, outcome
