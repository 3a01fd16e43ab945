"""Views pair on one hand, and never on two different ones; the misfit is one of the hand, not of the camera."""

from dataclasses import replace

import numpy as np
import pytest

from local_site.calibration.physical_camera import Lens
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.tracking.landmarks.hand_pairing import MOST_MISFIT, HandPairing
from local_site.tracking.learned.hand_starts import FIST
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG, landmarks_of, moved, seen_by_all
from tests.local_site.tracking.rendered_arm import ABOVE, ASIDE, PAIR, STEREO, rig_of, rows_of
from tests.local_site.tracking.silhouette.hand_model.posed_hands import pose_of
from tests.present import present

THREE = rig_of([camera.projection for camera in (*PAIR, ABOVE)])
FOUR = rig_of([camera.projection for camera in (*PAIR, ABOVE, ASIDE)])
HAND = landmarks_of(pose_of())
# Beside, above, and behind: what another person may do at the same desk.
OTHERS = [(0.15, 0.0, 0.05), (0.0, 0.0, 0.12), (0.1, 0.3, 0.1), (0.3, 0.6, 0.0)]


def shifted(hand, by):
    return replace(hand, points=hand.points + by)


def one_each(hands):
    return [[hand] for hand in hands]


def finer(rig, scale):
    """The rig with pictures of more pixels."""
    cameras = tuple(
        CameraCalibration(c.name, rows_of(np.diag([scale, scale, 1.0]) @ c.matrix), 0.0) for c in rig.cameras
    )
    return Rig(cameras, rig.volume_min, rig.volume_max, rig.error_rms, rig.created)


@pytest.mark.parametrize("rig", [PAIR_RIG, THREE, FOUR], ids=["two", "three", "four"])
def test_all_views_of_one_hand_meet_in_it(rig):
    found = HandPairing(rig).pairs(one_each(seen_by_all(rig, HAND)))
    assert set(found[0].views) == set(range(len(rig.cameras)))
    np.testing.assert_allclose(found[0].points, HAND, atol=1e-6)
    assert found[0].residual_px < 1e-4
    assert found[0].misfit < 1e-6


def test_what_is_seen_through_a_lens_is_undistorted_first():
    lens = Lens(STEREO.focal_px, STEREO.focal_px, 319.5, 239.5, -0.25)
    rig = Rig(
        tuple(CameraCalibration(c.name, c.projection, 0.0, lens) for c in PAIR_RIG.cameras),
        PAIR_RIG.volume_min,
        PAIR_RIG.volume_max,
        PAIR_RIG.error_rms,
        PAIR_RIG.created,
    )
    at = moved(HAND, (0.35, 0.0, 0.3))
    seen = seen_by_all(rig, at)
    assert np.abs(seen[0].points - seen_by_all(PAIR_RIG, at)[0].points).max() > 2.0
    (found,) = HandPairing(rig).pairs(one_each(seen))
    np.testing.assert_allclose(found.points, at, atol=1e-3)


@pytest.mark.parametrize("other", OTHERS)
def test_hands_of_two_people_do_not_pair(other):
    mine, theirs = (seen_by_all(PAIR_RIG, hand) for hand in (HAND, moved(HAND, other)))
    pairing = HandPairing(PAIR_RIG)
    assert pairing.pairs([[mine[0]], [theirs[1]]]) == []
    assert pairing.pairs([[theirs[0]], [mine[1]]]) == []
    found = pairing.pairs([[mine[0], theirs[0]], [theirs[1], mine[1]]])
    assert sorted(float(seen.points[0, 0]) for seen in found) == pytest.approx(
        sorted([float(HAND[0, 0]), float(HAND[0, 0]) + other[0]])
    )


def test_exchanged_views_do_not_pair():
    left, right = seen_by_all(PAIR_RIG, moved(HAND, (-0.1, 0.1, -0.15)))
    assert HandPairing(PAIR_RIG).pairs([[right], [left]]) == []


def test_another_posture_in_one_view_does_not_fit_as_well():
    left, right = seen_by_all(PAIR_RIG, HAND)
    fist = seen_by_all(PAIR_RIG, landmarks_of(pose_of((1.2, 0.0, 0.0), FIST)))[1]
    pairing = HandPairing(PAIR_RIG)
    (same,) = pairing.pairs([[left], [right]])
    other = pairing.pairs([[left], [fist]])
    assert not other or other[0].misfit > same.misfit + 0.02


@pytest.mark.parametrize("off_px", [8.0, 15.0])
def test_the_misfit_is_the_same_in_finer_pictures(off_px):
    misfits, residuals = [], []
    for scale in (1, 2):
        rig = finer(PAIR_RIG, scale)
        left, right = seen_by_all(rig, HAND)
        seen = present(HandPairing(rig).meet({0: left, 1: shifted(right, (0.0, scale * off_px / 2))}))
        misfits.append(seen.misfit)
        residuals.append(seen.residual_px)
    assert misfits[0] == pytest.approx(misfits[1], rel=1e-3)
    assert residuals[1] == pytest.approx(2 * residuals[0], rel=1e-3)
    assert 0 < misfits[0] < MOST_MISFIT


def test_views_that_miss_each_other_too_far_do_not_meet():
    left, right = seen_by_all(PAIR_RIG, HAND)
    pairing = HandPairing(PAIR_RIG)
    near, farther, far = (pairing.meet({0: left, 1: shifted(right, (0.0, off))}) for off in (4.0, 8.0, 60.0))
    assert present(near).misfit < present(farther).misfit < MOST_MISFIT
    assert far is None


def test_a_third_view_joins_where_it_agrees_and_is_left_out_where_it_does_not():
    hands = seen_by_all(THREE, HAND)
    pairing = HandPairing(THREE)
    far = shifted(hands[2], (120.0, 80.0))
    assert set(pairing.pairs([[hands[0]], [hands[1]], [far, hands[2]]])[0].views) == {0, 1, 2}
    assert pairing.pairs([[hands[0]], [hands[1]], [far, hands[2]]])[0].views[2] is hands[2]
    assert set(pairing.pairs([[hands[0]], [hands[1]], [far]])[0].views) == {0, 1}
    assert set(pairing.pairs([[hands[0]], [], [hands[2]]])[0].views) == {0, 2}


def test_the_best_agreement_comes_first():
    hands = seen_by_all(PAIR_RIG, HAND)
    off = shifted(hands[1], (0.0, 6.0))
    found = HandPairing(PAIR_RIG).pairs([[hands[0]], [off, hands[1]]])
    assert [seen.views[1] for seen in found] == [hands[1], off]


def test_a_hand_outside_of_the_calibrated_volume_is_none():
    near = Rig(PAIR_RIG.cameras, (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0), "exact")
    pairing = HandPairing(near)
    assert len(pairing.pairs(one_each(seen_by_all(near, HAND)))) == 1
    assert pairing.pairs(one_each(seen_by_all(near, moved(HAND, (0.0, 0.9, 0.0))))) == []


@pytest.mark.parametrize("points", [np.full((21, 2), np.nan), np.full((21, 2), np.inf)], ids=["nan", "infinite"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_points_that_are_no_numbers_do_not_pair(points):
    left, right = seen_by_all(PAIR_RIG, HAND)
    assert HandPairing(PAIR_RIG).pairs([[left], [replace(right, points=points)]]) == []


def test_nothing_seen_pairs_with_nothing():
    assert HandPairing(PAIR_RIG).pairs([[], []]) == []
    assert HandPairing(PAIR_RIG).pairs([seen_by_all(PAIR_RIG, HAND)[:1], []]) == []


def test_side_and_certainty_are_those_of_all_its_views():
    left, right = seen_by_all(PAIR_RIG, HAND)
    seen = present(HandPairing(PAIR_RIG).meet({0: replace(left, right=0.9, score=0.3), 1: replace(right, right=0.2)}))
    assert seen.right == pytest.approx(0.55)
    assert seen.score == pytest.approx(0.3)
