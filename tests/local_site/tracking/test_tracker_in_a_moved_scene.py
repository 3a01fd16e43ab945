"""Where the operator's frame lies does not matter: arm and cameras moved together give the same arm, moved."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from local_site.tracking.silhouette.hand_model.skeleton import turned
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from tests.local_site.tracking.rendered_arm import (
    MOVING,
    POINTS,
    render_sequence,
    rig_of,
)

FRAMES = 16
SHIFTED_M = 1e-6
# Iterations end, and the search for the hand begins, by the axes of the operator frame, and a tip may then settle on
# another edge: measured at most 0.6, 0.6, 6.6 and 0.2 mm.
TURNED_M = {"elbow": 1e-5, "wrist": 1e-5, "index": 1e-5, "thumb": 1e-5}


@pytest.fixture(scope="module")
def scene():
    """A short sequence with what is tracked in it."""
    sequence = render_sequence(MOVING, FRAMES)
    return sequence, sequence.tracked(SilhouetteTracker(rig_of(sequence.projections)))


def moved(sequence, rotation, shift):
    """What is tracked with everything turned (3, 3), then shifted (3,)."""
    back = np.eye(4)
    back[:3, :3], back[:3, 3] = rotation.T, -rotation.T @ shift
    return sequence.tracked(SilhouetteTracker(rig_of([m @ back for m in sequence.projections])))


def apart_m(first, second, name, rotation, shift):
    return max(
        np.linalg.norm(rotation @ getattr(a, name) + shift - getattr(b, name))
        for a, b in zip(first, second, strict=True)
        if getattr(a, name) is not None
    )


metres = st.floats(-3, 3)
turns = st.floats(-1.5, 1.5)


@settings(max_examples=3, deadline=None, derandomize=True)
@given(st.tuples(metres, metres, metres))
def test_a_shifted_scene_gives_the_same_arm_shifted(scene, shift):
    sequence, here = scene
    there = moved(sequence, np.eye(3), np.array(shift))
    assert [e.status for e in here] == [e.status for e in there]
    assert [e.reason for e in here] == [e.reason for e in there]
    for name in POINTS:
        assert apart_m(here, there, name, np.eye(3), np.array(shift)) < SHIFTED_M


@pytest.mark.slow
@settings(max_examples=5, deadline=None, derandomize=True)
@given(st.tuples(turns, turns, turns), st.tuples(metres, metres, metres))
def test_a_turned_scene_gives_the_same_arm_turned(scene, turn, shift):
    sequence, here = scene
    rotation = turned(np.array(turn))
    there = moved(sequence, rotation, np.array(shift))
    assert [e.status for e in here] == [e.status for e in there]
    for name in POINTS:
        assert apart_m(here, there, name, rotation, np.array(shift)) < TURNED_M[name]
        first, second = (e[-1].covariances[name] for e in (here, there))
        here_m, there_m = (np.sqrt(np.linalg.eigvalsh(m)) for m in (first, second))
        np.testing.assert_allclose(here_m, there_m, atol=0.002, rtol=0)
