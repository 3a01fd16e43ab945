"""Which postures of a bare hand toggle the gripper, by both trackers of one: those with the fingers seen apart."""

import numpy as np
import pytest

from local_site.samples.hand_sample import GestureConfig, OpenHand
from local_site.simulation.motion import Motion
from local_site.tracking.silhouette.hand_model.landmark_equations import CREASE
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from tests.local_site.tracking.learned.simulated_landmarks import shown_tracker
from tests.local_site.tracking.posture_films import BODY, FLAT_TOGETHER, POSTURES, SPREADS, STILL, Shown, film, posed
from tests.local_site.tracking.rendered_arm import rig_of

SHOWN = {name: (shown, 0) for name, shown in POSTURES.items()} | {name: (shown, 1) for name, shown in SPREADS.items()}
ROLLS_DEG = range(-90, 111, 20)


def toggles(estimates):
    """The openings that are counted."""
    hand = OpenHand()
    for estimate in estimates:
        hand = hand.observe(estimate, GestureConfig())
    assert not hand.is_open
    return hand.toggles


@pytest.fixture(scope="module", params=SHOWN)
def seen(request):
    """A posture, its film, and how often it toggles: filmed once for both trackers."""
    shown, expected = SHOWN[request.param]
    return shown, film(shown), expected


def silhouette(sequence):
    """The estimates of the tracker of outlines."""
    return sequence.tracked(SilhouetteTracker(rig_of(sequence.projections)))


def learned(shown, sequence, patch):
    """The estimates of the tracker of landmarks, which are seen as they are."""
    motion = Motion(STILL, BODY, 1)
    tracker = shown_tracker(patch, sequence.projections)
    return [tracker.track(sequence.views(k), landmarks_of(motion, shown, k)) for k in range(len(sequence.times_s))]


def landmarks_of(motion, shown, k):
    """The landmarks (21, 3) in m of the hand at the k-th instant."""
    body, pose = posed(motion, shown, k)
    *fingers, thumb = body.joints(pose)
    crease = pose.wrist + CREASE * (fingers[1][0] - pose.wrist)
    return np.vstack([crease, thumb, *fingers])


@pytest.mark.slow
def test_by_outlines_only_a_hand_with_its_fingers_apart_toggles(seen):
    _, sequence, expected = seen
    estimates = silhouette(sequence)
    assert all(estimate.wrist is not None for estimate in estimates)
    assert toggles(estimates) == expected


@pytest.mark.slow
def test_by_landmarks_only_a_hand_with_its_fingers_apart_toggles(seen, monkeypatch):
    shown, sequence, expected = seen
    assert toggles(learned(shown, sequence, monkeypatch)) == expected


@pytest.mark.slow
@pytest.mark.parametrize("roll_deg", [-10, 90])
def test_a_flat_hand_still_shows_no_u_so_that_its_orientation_is_not_copied(roll_deg):
    assert any(estimate.hand_open for estimate in silhouette(film(Shown(FLAT_TOGETHER, roll_deg))))


@pytest.mark.long
@pytest.mark.parametrize("roll_deg", ROLLS_DEG)
@pytest.mark.parametrize("name", ["flat, turning", "flat, the thumb tucked in", "spread"])
def test_it_does_not_matter_which_side_of_the_hand_the_cameras_see(name, roll_deg, monkeypatch):
    shown, expected = SHOWN[name]
    rolled = Shown(shown.posture, float(roll_deg))
    sequence = film(rolled)
    assert toggles(silhouette(sequence)) == expected
    assert toggles(learned(rolled, sequence, monkeypatch)) == expected
