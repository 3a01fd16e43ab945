"""The tracking benchmark as a whole, on a short scene: all trackers' figures, or why one is left out."""

import io
from contextlib import ExitStack, nullcontext
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from common.errors import NotInstalledError
from lab.films.scenes import simulated
from lab.measure.tracking import comparison as tracking
from lab.measure.tracking.comparison import Comparison
from lab.measure.tracking.figures import SETTLED, Found
from lab.measure.tracking.mediapipe_hands import MediaPipeHands
from lab.stage.processes import UnavailableError
from local_site.simulation.config import MotionConfig, SimulationConfig

PAIRS = 16
SCENE = simulated("short", SimulationConfig(motion=MotionConfig(name="hold")), PAIRS / 30)
THEIRS_MS = 50.0


class Stub:
    """Replaces MediaPipe: answers this many pairs, then ends."""

    def __init__(self, answers):
        self.answers = answers

    def track(self, *_pair):
        self.answers -= 1
        if self.answers < 0:
            raise UnavailableError("the child ended")
        return Found({"wrist": np.zeros(3), "index": np.zeros(3)}, THEIRS_MS, THEIRS_MS, covariances={})


def compare(monkeypatch, answers, scene=SCENE):
    """Figures, totals and text of a comparison whose MediaPipe answers this many pairs."""
    monkeypatch.setattr(tracking, "install", lambda: "python")

    class StubbedHands(MediaPipeHands):
        def __new__(cls, _python):
            return nullcontext(Stub(answers))

    monkeypatch.setattr(tracking, "MediaPipeHands", StubbedHands)
    console = Console(width=120, record=True, file=io.StringIO())
    with ExitStack() as others:
        comparison = Comparison(console, others)
        return comparison.measure(scene), comparison.totals(), console.export_text()


def test_both_trackers_are_measured_on_the_same_pairs(monkeypatch):
    figures, totals, text = compare(monkeypatch, PAIRS)
    assert figures["simulated short, silhouette, frames"] == figures["simulated short, MediaPipe Hands, frames"] == 6
    assert figures["simulated short, silhouette, frames without result"] == 0
    assert 0 < figures["simulated short, silhouette, wrist, mean mm"] < 40
    assert figures["simulated short, MediaPipe Hands, wrist, mean mm"] > 500
    ours = figures["simulated short, silhouette, median ms per pair"]
    assert totals["MediaPipe's median time by ours"] == pytest.approx(THEIRS_MS / ours)
    assert "skipped" not in text


@pytest.mark.parametrize("answers", [0, 7])
def test_a_mediapipe_that_ends_is_left_out_with_the_reason(answers, monkeypatch):
    figures, totals, text = compare(monkeypatch, answers)
    assert not any("MediaPipe" in name for name in figures)
    assert totals["MediaPipe measured"] == 0.0
    assert "MediaPipe Hands skipped: the child ended" in text
    assert figures["simulated short, silhouette, frames"] == 6


def from_the_sixth_on(scene, methods):
    """The scene with an arm that is not there at first, as far as the truth knows."""

    def instants():
        return (replace(i, truth=None) if k < 5 else i for k, i in enumerate(scene.instants()))

    return replace(scene, instants=instants, methods=methods)


def test_pairs_without_the_arm_are_shown_to_all_and_judged_for_none(monkeypatch):
    figures, _, text = compare(monkeypatch, PAIRS, from_the_sixth_on(SCENE, ("silhouette",)))
    names = ("silhouette", "MediaPipe Hands")
    assert [figures[f"simulated short, {name}, frames"] for name in names] == [PAIRS - 5 - SETTLED] * 2
    assert "skipped" not in text


def test_a_tracker_without_its_models_is_left_out_with_the_cure(monkeypatch):
    def missing(*_):
        raise NotInstalledError("run 'farhand models install'")

    monkeypatch.setattr("local_site.tracking.factories.LearnedTracker", missing)
    figures, totals, text = compare(monkeypatch, PAIRS, replace(SCENE, methods=("silhouette", "learned")))
    assert "learned skipped: run 'farhand models install'" in text
    assert totals["learned measured"] == 0.0
    assert not any("learned" in name for name in figures)
