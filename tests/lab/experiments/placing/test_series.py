"""The figures of a series: medians and quartiles of the placed trials, and counts of all."""

import json

import pytest

from lab.experiments.placing import series
from lab.experiments.placing.judge import Placed
from lab.experiments.placing.trial import Conditions, TrialResult


def result(x_mm=1.0, placed=True, drops=0):
    return TrialResult(Placed(x_mm, -2.0, 0.5, placed), 30.0, drops, 1, 3, 0, 0, 20.0)


@pytest.fixture
def report(monkeypatch):
    monkeypatch.setattr(series, "QUICK_SEEDS", (1, 2, 3, 5))
    monkeypatch.setattr(series, "is_installed", lambda _: True)
    conditions = series.placing_conditions(quick=True)
    return series.placing_report({c: result(x_mm=(-1) ** c.seed * c.seed, placed=c.seed != 2) for c in conditions})


def test_report_json_has_the_promised_form(report):
    figures = json.loads(json.dumps(report.figures))
    assert set(figures) == {"roll_fixed", "free"}
    for by_method in figures.values():
        assert set(by_method) == {"silhouette", "markers", "learned", "assist"}
        for of in by_method.values():
            for name in ("x_mm", "y_mm", "angle_deg"):
                assert set(of[name]) == {"median", "q1", "q3"}
            assert {"placed", "trials", "drops", "time_s"} <= set(of)


def test_errors_are_those_of_the_placed_trials_without_sign(report):
    of = report.figures["free"]["markers"]
    assert (of["placed"], of["trials"]) == (3, 4)
    assert of["x_mm"] == {"median": 3.0, "q1": 2.0, "q3": 4.0}
    assert of["y_mm"]["median"] == 2.0


def test_a_row_for_every_trial_and_a_plot_of_all(report):
    assert report.data["placing_free_markers"].rows[:, 1].tolist() == [-1.0, 2.0, -3.0, -5.0]
    assert report.plots["placing"].startswith(b"\x89PNG")


def test_a_series_in_which_nothing_was_placed_still_has_a_report():
    report = series.placing_report({c: result(placed=False) for c in series.placing_conditions(quick=True)})
    assert report.figures["free"]["silhouette"]["x_mm"]["median"] is None
    assert "placed 0 of 2" in report.summary


def test_the_seeds_of_the_series_are_none_that_parameters_were_chosen_on():
    seeds = {each.seed for each in series.placing_conditions(quick=False)}
    assert len(seeds) == 20
    assert seeds.isdisjoint(series.QUICK_SEEDS)
    assert Conditions("silhouette", True, 9).seed not in seeds


def test_a_tracker_that_is_not_installed_is_left_out(monkeypatch):
    monkeypatch.setattr(series, "is_installed", lambda method: method != "learned")
    report = series.placing_report({c: result() for c in series.placing_conditions(quick=True)})
    assert set(report.figures["free"]) == {"silhouette", "markers", "assist"}
