"""The tracking benchmark as a whole, on a short scene: both trackers' figures, or ours with the reason for the gap."""

import io
from contextlib import ExitStack, nullcontext

import numpy as np
import pytest
from rich.console import Console

from bench.processes import UnavailableError
from bench.tracking import comparison as tracking
from bench.tracking.comparison import Comparison
from bench.tracking.figures import Found
from bench.tracking.mediapipe_hands import MediaPipeHands
from bench.tracking.scenes import simulated
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


def compare(monkeypatch, answers):
    """Figures, totals and text of a comparison whose MediaPipe answers this many pairs."""
    monkeypatch.setattr(tracking, "install", lambda: "python")

    def start(_python):
        return nullcontext(Stub(answers))

    start.name, start.needed = MediaPipeHands.name, MediaPipeHands.needed
    monkeypatch.setattr(tracking, "MediaPipeHands", start)
    console = Console(width=120, record=True, file=io.StringIO())
    with ExitStack() as others:
        comparison = Comparison(console, others)
        return comparison.measure(SCENE), comparison.totals(), console.export_text()


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
