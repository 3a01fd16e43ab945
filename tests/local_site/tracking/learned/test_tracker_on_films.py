"""The tracker on films of an arm's mesh before rooms: tracked where the operator's arm is, and nowhere else."""

from itertools import islice

import numpy as np
import pytest

from common.messages.hand import TrackingStatus
from lab.films.listing import mesh_films

pytestmark = pytest.mark.long  # rendering; test_tracker_in_an_office.py covers the same ground

SEED = 1
KNOWN, UNTIL, EMPTY_UNTIL = 65, 100, 60
SHARE = 0.8
# About half more than measured.
MEAN_MM = {"elbow": 20.0, "wrist": 12.0, "index": 28.0, "thumb": 10.0}
SAME_HAND_MM = 60.0


def tracked(make_tracker, name, until):
    """Estimates and truths of a film's first instants."""
    (film,) = (film for film in mesh_films(SEED) if film.name == name)
    tracker = make_tracker(film.rig)
    return [(tracker.track(instant.views), instant.truth) for instant in islice(film.instants(), until)]


def test_an_arm_is_tracked_in_an_office(make_tracker):
    seen = tracked(make_tracker, "office, medium, carry, empty first", UNTIL)
    sure = [(estimate, truth.arm) for estimate, truth in seen[KNOWN:] if estimate.status is TrackingStatus.TRACKED]
    assert len(sure) >= SHARE * (UNTIL - KNOWN)
    for name, limit_mm in MEAN_MM.items():
        points = [(getattr(e, name), getattr(t, name)) for e, t in sure if getattr(e, name) is not None]
        errors = [1e3 * np.linalg.norm(one - other) for one, other in points]
        assert np.mean(errors) < limit_mm
        assert np.max(errors) < SAME_HAND_MM


@pytest.mark.parametrize("name", ["plain, left arm, carry", "no arm, poster of a hand", "no arm, another person"])
def test_what_is_not_the_operators_arm_is_never_tracked(make_tracker, name):
    seen = tracked(make_tracker, name, EMPTY_UNTIL)
    assert {estimate.status for estimate, _ in seen} <= {TrackingStatus.LOST, TrackingStatus.INITIALISING}
    assert all(estimate.reason for estimate, _ in seen)
