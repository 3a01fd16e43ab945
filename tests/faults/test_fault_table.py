"""Every fault of the table on real processes: as promised, and within the limits in every command."""

import time

import pytest
from conftest import Stage
from fault_rows import ROWS, Row
from trial import Trial

from common.errors import FarhandError


@pytest.mark.faults
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.fault)
def test_full(row: Row, stage: Stage) -> None:
    begun = time.monotonic()
    trial = Trial(stage.pair_for(row))
    try:
        trial.pair.engage()
        row.play(trial)
        trial.end()
    except (AssertionError, OSError, FarhandError) as error:
        trial.outcome.failures.append(str(error))
    stage.report.add(row, trial.outcome, time.monotonic() - begun)
    stage.settle(trial)
    assert not trial.outcome.failures, trial.outcome
