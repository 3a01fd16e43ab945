"""The experiments on one camera's arm, cut short: every run and plot is there, figures are those of the runs."""

import numpy as np
import pytest

from farhand.experiments import drift, hazel
from farhand.experiments.hazel_figures import (
    REPORT_C,
    REPORT_S,
    arm_figures,
    errors_mm,
    track_footage,
    with_occluder,
)
from local_site.tracking.config import MonocularConfig

FRAMES = 4
DISTURBED = (
    "radius - 5 %",
    "radius + 5 %",
    "grey noise 6",
    "turned by 149 deg in the picture",
    "3 x speed",
    "small occluder",
)


@pytest.fixture(scope="module")
def report():
    with pytest.MonkeyPatch.context() as short:
        short.setattr(hazel, "QUICK_FRAMES", FRAMES)
        frames = []
        made = hazel.hazel_report(True, lambda: frames.append(1))
        assert len(frames) == hazel.frame_count(True)
    return made


@pytest.mark.long
def test_every_disturbance_is_reported_beside_the_reports_own_figures(report):
    runs = report.compared
    assert set(runs) == {
        "report, HAZEL-S",
        "accurate",
        "live",
        *(f"live, {name}" for name in DISTURBED),
        "report, HAZEL-C",
        "rectangle, live",
    }
    assert (runs["report, HAZEL-S"], runs["report, HAZEL-C"]) == (REPORT_S, REPORT_C)
    for name in ("accurate", "live", *(f"live, {name}" for name in DISTURBED)):
        figures = runs[name]
        assert figures["frames"] == FRAMES
        assert figures["called_tracked_over_50_mm"] == 0
        assert max(figures[f"{joint}_mm"]["mean"] for joint in ("shoulder", "elbow", "wrist")) < 5.0
    assert 0.0 < runs["rectangle, live"]["finger_tip_mm"]["mean"] < 5.7
    assert "accurate: shoulder " in report.summary


@pytest.mark.long
def test_plots_and_data_are_those_of_the_reports_figures(report):
    figures = ("10_motion", "11_positions", "12_errors", "15_finger_tip", "16_finger_errors")
    assert {f"figure_{name}" for name in figures} == set(report.plots)
    assert {name: data.rows.shape for name, data in report.data.items()} == {
        "hazel_s_accurate": (FRAMES, 10),
        "hazel_s_live": (FRAMES, 10),
        "hazel_c": (FRAMES, 7),
    }


@pytest.mark.long
def test_a_loss_in_the_middle_is_counted_and_leaves_a_gap():
    swing = hazel._swing(hazel.Swing(), FRAMES, hazel.Scenery(), lambda: None)
    hidden = with_occluder(swing, (0, 0, 640, 480), range(2, 3), 90)
    tracked = track_footage(hidden, MonocularConfig(), 0.0)
    figures = arm_figures(tracked)
    assert figures["lost"] == 1
    assert np.isnan(errors_mm(tracked, "wrist")[2]).all()
    assert np.isfinite(errors_mm(tracked, "wrist")[[0, 1, 3]]).all()


def test_the_drift_of_the_incremental_command_stands_beside_the_relative_one(monkeypatch):
    monkeypatch.setattr(drift, "QUICK_FRAMES", 30)
    report = drift.drift_report(True, lambda: None)
    ends = {name: figures["off_mm"]["last"] for name, figures in report.compared.items()}
    assert ends[drift.ARRIVING] < 1e-6
    assert ends["relative"] < 25.0
    assert ends["incremental"] > 2.0 * ends["relative"]
    assert report.data["drift"].rows.shape == (30, 10)
    assert set(report.plots) == {"drift"}
    assert "incremental, an arm that arrives: 0.0 mm" in report.summary
