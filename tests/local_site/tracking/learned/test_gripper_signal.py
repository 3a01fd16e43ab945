"""The gripper's signal: the open hand of the simulated operator is seen as open, and the closed one as closed."""

import numpy as np
import pytest

from local_site.simulation.config import MotionConfig
from tests.local_site.tracking.learned.simulated_landmarks import shown_tracker, simulated_landmarks
from tests.local_site.tracking.rendered_arm import render_sequence

TOGGLES = MotionConfig(name="toggles", still_s=0.4)
PAIRS = 90  # the hand is opened once
AGREED = 0.9


@pytest.mark.slow
def test_one_opening_is_seen_once(monkeypatch):
    sequence = render_sequence(TOGGLES, PAIRS)
    shown = shown_tracker(monkeypatch, sequence.projections)
    seen = [shown.track(sequence.views(k), simulated_landmarks(sequence, k, TOGGLES)).hand_open for k in range(PAIRS)]
    true = [truth.hand_open for truth in sequence.truths]
    assert np.mean(np.equal(seen, true)) > AGREED
    assert np.count_nonzero(np.diff(np.array(seen[10:], dtype=int)) == 1) == 1
