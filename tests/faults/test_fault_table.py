"""Every fault of the table on real processes: as promised, and within the limits in every command."""

import time

import pytest

from common.clock import NS_PER_S
from tests.faults.conftest import Stage
from tests.faults.fault_rows import ROWS, Row
from tests.faults.trial import Outcome, Trial

BY_SETTINGS = sorted(ROWS, key=lambda row: row.settings)
PLAYS = 3
SHARED_MACHINE_NS = 2 * NS_PER_S  # a machine under tests may be this late with a stop; 'make faults' allows no delay


def play_patiently(row: Row, stage: Stage) -> Outcome:
    """Play a row on a machine that is shared; once more where that was too late for the samples, as no such row is."""
    for _ in range(PLAYS):
        outcome = play(row, stage, SHARED_MACHINE_NS)
        if not (outcome.failures and outcome.was_late):
            break
    return outcome


def play(row: Row, stage: Stage, pause_ns: int = 0) -> Outcome:
    """Play a row on the pair that it needs, and report what came of it."""
    begun, outcome, trial = time.monotonic(), Outcome(), None
    try:
        trial = Trial(stage.pair_for(row), outcome, pause_ns)
        if row.engaged:
            trial.pair.engage()
        row.play(trial)
        trial.end()
    except (Exception, pytest.fail.Exception) as error:  # whatever it is, the row has failed, and is reported
        outcome.failures.append(f"{type(error).__name__}: {error}")
    if outcome.failures and trial is not None:
        outcome.was_late = trial.was_late()
    stage.report.add(row, outcome, time.monotonic() - begun)
    stage.settle(outcome)
    return outcome


@pytest.mark.faults
@pytest.mark.parametrize("row", BY_SETTINGS, ids=lambda row: row.fault)
def test_full(row: Row, stage: Stage) -> None:
    outcome = play(row, stage)
    assert not outcome.failures, outcome


@pytest.mark.slow
@pytest.mark.parametrize("row", [row for row in ROWS if row.quick], ids=lambda row: row.fault)
def test_shortened(row: Row, one_host: Stage) -> None:
    outcome = play_patiently(row, one_host)
    assert not outcome.failures, outcome
