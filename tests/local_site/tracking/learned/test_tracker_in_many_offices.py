"""The tracker in simulated offices: tones of skin, postures, disturbances, more and finer cameras, lenses, phases."""

from functools import partial

import numpy as np
import pytest
from msgspec.structs import replace

from common.messages.hand import TrackingStatus
from local_site.simulation.cameras import calibrate_simulated, stereo_pair
from local_site.simulation.config import MotionConfig, StereoConfig
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.tracker import TrackingReason, Views
from tests.local_site.tracking.learned.office_films import CARRY, EMPTY_S, Tracked, filmed, office, track
from tests.local_site.tracking.rendered_arm import ABOVE, ASIDE, PAIR, PERIOD_S, STEREO, rig_of

pytestmark = pytest.mark.long  # test_tracker_in_an_office.py covers the same ground

PAIRS, KNOWN = 110, 80
SHARE = 0.8
BENT_K1 = -0.2
LATE_S = 0.5 * PERIOD_S
EVERYTHING = ("second_arm", "face", "hand_poster", "fan", "shadows")
# Far less than the distance to any other hand.
SAME_HAND_MM = 100.0


def room(**kind):
    return RoomConfig(scene="office", empty_s=EMPTY_S, **kind)


def moving(name, **kind):
    return MotionConfig(name=name, still_s=0.3, **kind)


# Limits are means in mm, about half more than measured.
FILMS = {
    "dark, turning": (room(skin="dark"), moving("rotate_y"), {"elbow": 12, "wrist": 6, "index": 12, "thumb": 8}),
    "medium, before wood": (
        room(skin="medium", disturbances=("wood",)),
        moving("figure_of_eight"),
        {"elbow": 15, "wrist": 6, "index": 16, "thumb": 8},
    ),
    "with everything": (room(disturbances=EVERYTHING), CARRY, {"elbow": 14, "wrist": 17, "index": 14, "thumb": 12}),
    "pointing": (
        room(skin="medium"),
        moving("rotate_z", posture="pointing"),
        {"elbow": 12, "wrist": 12, "index": 5, "thumb": 15},  # the thumb lies before bent fingers, and is inferred
    ),
    "flat": (room(), moving("figure_of_eight", posture="flat"), {"elbow": 18, "wrist": 8, "index": 8, "thumb": 6}),
    "with a watch": (room(watch=True), CARRY, {"elbow": 12, "wrist": 12, "index": 17, "thumb": 8}),
}
FIST_WRIST_MM = 8.0
USUAL_MM = {"elbow": 13, "wrist": 9, "index": 21, "thumb": 8}


def check(seen, limits_mm):
    assert seen.share(KNOWN) >= SHARE
    for name, limit_mm in limits_mm.items():
        errors = seen.errors_mm(name)
        assert errors.mean() < limit_mm
        assert errors.max() < SAME_HAND_MM


@pytest.mark.parametrize("name", FILMS)
def test_any_arm_is_tracked(make_tracker, name):
    setting, motion, limits_mm = FILMS[name]
    check(track(make_tracker, filmed(office(setting, motion), PAIRS)), limits_mm)


def test_a_fist_is_degraded_with_the_reason(make_tracker):
    seen = track(make_tracker, filmed(office(room(), moving("rotate_x", posture="fist")), PAIRS))
    held = seen.estimates[KNOWN:]
    assert all(estimate.status is not TrackingStatus.TRACKED for estimate in held)
    assert np.mean([TrackingReason.FIST in estimate.reason for estimate in held]) >= SHARE
    off = [e.wrist - t.wrist for e, t in zip(held, seen.sequence.truths[KNOWN:], strict=True) if e.wrist is not None]
    assert 1e3 * np.mean(np.linalg.norm(off, axis=1)) < FIST_WRIST_MM


@pytest.mark.parametrize("cameras", [(*PAIR, ABOVE), (*PAIR, ABOVE, ASIDE)], ids=["three", "four"])
def test_more_cameras_track(make_tracker, cameras):
    seen = track(make_tracker, filmed(office(room()), PAIRS, cameras))
    check(seen, USUAL_MM)
    assert len(seen.estimates[-1].overlays) == len(cameras)


def with_one_black(covered, images):
    return [0 * image if n == covered else image for n, image in enumerate(images)]


def test_one_of_three_cameras_may_be_covered(make_tracker):
    sequence = filmed(office(room()), PAIRS, (*PAIR, ABOVE))
    tracker, estimates = make_tracker(rig_of(sequence.projections)), []
    for k in range(PAIRS):
        covered = (k // 5) % 3 if k > KNOWN else None
        estimates.append(tracker.track(sequence.views(k, partial(with_one_black, covered))))
    check(Tracked(estimates, sequence), USUAL_MM)


def test_finer_pictures_track(make_tracker):
    fine = StereoConfig(width_px=1280, height_px=960, focal_px=2 * STEREO.focal_px)
    config = replace(office(room()), stereo=fine)
    check(track(make_tracker, filmed(config, PAIRS, stereo_pair(fine))), USUAL_MM)


def test_bent_lenses_track(make_tracker):
    bent = StereoConfig(k1=BENT_K1)
    config = replace(office(room()), stereo=bent)
    sequence = filmed(config, PAIRS, stereo_pair(bent))
    tracker = make_tracker(calibrate_simulated(config))
    check(Tracked(sequence.tracked(tracker), sequence), USUAL_MM)


def test_cameras_out_of_phase_are_brought_to_one_instant(make_tracker):
    sequence = filmed(office(room()), PAIRS, late_s=LATE_S)
    tracker = make_tracker(rig_of(sequence.projections))
    estimates = [tracker.track(sequence.views(0))]
    for k in range(1, PAIRS):
        views = (sequence.views(k).views[0], sequence.between(k, 1, LATE_S))
        estimates.append(tracker.track(Views(sequence.views(k).t_ns, views)))
    check(Tracked(estimates, sequence), USUAL_MM)


def test_a_left_arm_among_others_is_never_tracked(make_tracker):
    crowded = room(disturbances=(*EVERYTHING, "wood"))
    sequence = filmed(office(RoomConfig(scene="office", empty_s=60.0, disturbances=crowded.disturbances)), 4 * PAIRS)
    seen = track(make_tracker, sequence)
    assert seen.statuses <= {TrackingStatus.LOST, TrackingStatus.INITIALISING}
    assert np.mean([bool(estimate.reason) for estimate in seen.estimates]) == 1.0
