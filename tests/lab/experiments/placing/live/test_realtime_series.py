"""The report of the trials in real time, with those in lockstep beside them."""

import json

import numpy as np
import pytest

from lab.experiments.placing.judge import Placed
from lab.experiments.placing.kept_trials import KeptTrials
from lab.experiments.placing.live import series
from lab.experiments.placing.live.pace import LiveResult, Pace
from lab.experiments.placing.series import FIRST_SEED
from lab.experiments.placing.trial import TrialResult


def trial(x_mm, time_s):
    return TrialResult(Placed(x_mm, -2.0, 0.5, True), time_s, 0, 1, 3, 0, 0, 20.0, 60.0)


def live(conditions):
    pace = Pace(1000, conditions.seed - FIRST_SEED, 0, 1, 30.0, 0, 22.0, 70.0, 9.5, 30.0, {"ok": 2})
    return LiveResult(trial(float(conditions.seed - FIRST_SEED), 40.0), pace)


@pytest.fixture
def made(monkeypatch, tmp_path):
    ran, kept = [], KeptTrials(tmp_path, "1")
    for conditions in series.live_conditions(quick=False):
        kept.keep(conditions, trial(1.0, 30.0))
    monkeypatch.setattr(series, "run_live", lambda conditions: ran.append(conditions) or live(conditions))
    steps = []
    return ran, steps, series.realtime_report(False, lambda: steps.append(1), kept)


def test_ten_seeds_of_the_stepped_series_half_of_them_with_the_roll_fixed(made):
    ran, steps, _ = made
    assert [each.seed for each in ran] == [FIRST_SEED + k for k in range(10)]
    assert [each.roll_fixed for each in ran] == [True] * 5 + [False] * 5
    assert {each.method for each in ran} == {"silhouette"}
    assert len(steps) == series.trial_count(quick=False) == 20


def test_both_series_and_the_machines_pace_are_in_the_report(made):
    figures = json.loads(json.dumps(made[2].figures))
    assert set(figures) == {"roll_fixed", "free"}
    fixed = figures["roll_fixed"]
    assert (fixed["real_time"]["x_mm"]["median"], fixed["lockstep"]["x_mm"]["median"]) == (2.0, 1.0)
    assert (fixed["real_time"]["time_s"]["median"], fixed["lockstep"]["time_s"]["median"]) == (40.0, 30.0)
    pace = fixed["pace"]
    assert (pace["periods"], pace["missed"], pace["missed_percent"], pace["looks_per_s"]) == (5000, 10, 0.2, 9.5)
    assert pace["looks_by_reason"] == {"ok": 10}
    assert "10 of 5000 control periods missed" in made[2].summary


def test_a_row_for_every_trial_and_a_plot(made):
    data = made[2].data
    assert data["real_time_free"].rows[:, 1].tolist() == [5.0, 6.0, 7.0, 8.0, 9.0]
    assert data["lockstep_free"].rows[:, 1].tolist() == [1.0] * 5
    assert data["pace_roll_fixed"].rows[:, 2].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert all(np.isfinite(table.rows).all() for table in data.values())
    assert made[2].plots["realtime"].startswith(b"\x89PNG")


def test_a_quick_run_is_one_trial_of_a_seed_outside_the_series():
    (only,) = series.live_conditions(quick=True)
    assert only not in series.live_conditions(quick=False)
    assert only.seed < FIRST_SEED
