"""One hand is found, followed and lost: never another one, and no single view is followed for long."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from local_site.tracking.landmarks.hand_finder import MOST_RETRIES, HandFinder
from local_site.tracking.landmarks.hand_pairing import SeenHand
from local_site.tracking.tracker import TrackingReason
from tests.local_site.tracking.landmarks.scripted_hands import instant, scripted_views, show
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG, landmarks_of, moved, seen_by_all
from tests.local_site.tracking.rendered_arm import ABOVE, PAIR, rig_of
from tests.local_site.tracking.silhouette.hand_model.posed_hands import pose_of

HAND = landmarks_of(pose_of())
THREE = rig_of([camera.projection for camera in (*PAIR, ABOVE)])
ELSEWHERE = (0.0, 0.05, 0.25)
STEP = (0.015, 0.0, 0.01)


@pytest.fixture
def pair():
    views = scripted_views(PAIR_RIG)
    return HandFinder(PAIR_RIG, views), views


def anyone(_):
    return 0.0


def nobody(_):
    return math.inf


def doubted_unless_at(place, doubt):
    """Doubts every hand whose middle is not at a place (3,) in m."""
    return lambda hand: 0.0 if np.linalg.norm(hand.points.mean(axis=0) - place) < 0.01 else doubt


def find(finder, k, doubt=anyone, weight=1.0, cameras=2):
    return finder.find(instant(k, cameras, weight), doubt, quickly=False)


def seen(at=(0.0, 0.0, 0.0), **kind):
    return seen_by_all(PAIR_RIG, moved(HAND, at), **kind)


def is_at(found, at):
    return isinstance(found, SeenHand) and np.allclose(found.points, moved(HAND, at), atol=1e-4)


def test_nothing_seen_says_so(pair):
    finder, views = pair
    assert find(finder, 0) == TrackingReason.NO_HAND
    assert not any(view.is_following for view in views)


def test_a_hand_is_found_and_followed_in_all_views(pair):
    finder, views = pair
    for k in range(5):
        at = tuple(k * step for step in STEP)
        show(views, seen(at))
        assert is_at(find(finder, k), at)
        assert [view.kept for view in views] == [view.shown[0] for view in views]


def test_a_hand_that_is_not_the_operators_is_refused_and_not_followed(pair):
    finder, views = pair
    show(views, seen())
    assert find(finder, 0, nobody) == TrackingReason.OTHER_HAND
    assert not any(view.is_following for view in views)


@pytest.mark.parametrize("doubt", [1.0, math.inf])
@pytest.mark.parametrize("is_first", [True, False])
def test_of_two_hands_the_less_doubted_is_taken(pair, doubt, is_first):
    finder, views = pair
    show(views, *([seen(), seen(ELSEWHERE)] if is_first else [seen(ELSEWHERE), seen()]))
    found = find(finder, 0, doubted_unless_at(HAND.mean(axis=0), doubt))
    assert is_at(found, (0.0, 0.0, 0.0))


def test_a_doubted_hand_is_found_but_not_followed_until_another_offers(pair):
    finder, views = pair
    own = doubted_unless_at(HAND.mean(axis=0), 1.0)
    show(views, seen(ELSEWHERE))
    for k in range(3):
        assert is_at(find(finder, k, own), ELSEWHERE)
        assert not any(view.is_following for view in views)
    show(views, seen(ELSEWHERE), seen())
    assert is_at(find(finder, 3, own), (0.0, 0.0, 0.0))
    assert all(view.is_following for view in views)


def test_a_jump_to_another_hand_is_refused(pair):
    finder, views = pair
    for k in range(3):
        show(views, seen())
        find(finder, k)
    show(views, seen(ELSEWHERE))
    assert find(finder, 3) == TrackingReason.OTHER_HAND
    assert not any(view.is_following for view in views)


def test_a_second_hand_that_comes_in_is_never_taken(pair):
    finder, views = pair
    for k in range(12):
        at = tuple(0.3 * k * step for step in STEP)
        theirs = (0.0, 0.1, 0.3 - 0.01 * k)
        show(views, *([seen(theirs), seen(at)] if k % 2 else [seen(at), seen(theirs)]))
        if k < 3:
            show(views, seen(at))
        assert is_at(find(finder, k), at)


def test_a_fast_hand_is_followed(pair):
    finder, views = pair
    for k in range(6):
        at = (0.05 * k, 0.0, -0.03 * k)  # 1.7 m/s
        show(views, seen(at))
        assert is_at(find(finder, k), at)


def test_after_a_short_loss_it_is_looked_for_where_it_was(pair):
    finder, views = pair
    for k in range(3):
        show(views, seen())
        find(finder, k)
    show(views)
    assert find(finder, 3) == TrackingReason.NO_HAND
    show(views, seen(ELSEWHERE))
    assert find(finder, 4) == TrackingReason.OTHER_HAND
    show(views, seen(ELSEWHERE), seen(STEP))
    assert is_at(find(finder, 5), STEP)


def test_after_a_long_loss_it_may_be_anywhere(pair):
    finder, views = pair
    for k in range(3):
        show(views, seen())
        find(finder, k)
    show(views)
    for k in range(3, 15):
        assert find(finder, k) == TrackingReason.NO_HAND
    show(views, seen(ELSEWHERE))
    assert is_at(find(finder, 15), ELSEWHERE)


def test_forgetting_makes_all_views_search(pair):
    finder, views = pair
    show(views, seen())
    find(finder, 0)
    finder.forget()
    assert not any(view.is_following for view in views)
    show(views, seen(ELSEWHERE))
    assert is_at(find(finder, 1), ELSEWHERE)


def test_a_hand_that_one_view_alone_sees_is_not_followed(pair):
    finder, views = pair
    views[0].shown = [seen()[0]]
    for k in range(5):
        assert find(finder, k) == TrackingReason.HANDS_DIFFER
        assert not any(view.is_following for view in views)
    show(views, seen())
    assert is_at(find(finder, 5), (0.0, 0.0, 0.0))


def test_views_that_see_different_hands_are_lost_with_the_reason(pair):
    finder, views = pair
    views[0].shown, views[1].shown = [seen()[0]], [seen(ELSEWHERE)[1]]
    assert find(finder, 0) == TrackingReason.HANDS_DIFFER


def test_a_hand_that_a_view_doubts_must_fit_the_better(pair):
    finder, views = pair
    left, right = seen(score=0.2)
    show(views, [left, right])
    assert is_at(find(finder, 0), (0.0, 0.0, 0.0))
    off = replace(right, points=np.add(right.points, (0.0, 13.0)))
    show(views, [left, off])
    doubted = find(finder, 1)
    show(views, [replace(left, score=0.9), replace(off, score=0.9)])
    assert doubted == TrackingReason.HANDS_DIFFER
    assert isinstance(find(finder, 2), SeenHand)


def test_a_view_that_takes_it_for_its_mirror_image_looks_again(pair):
    finder, views = pair
    left, right = seen()
    flipped = replace(right, right=0.1, points=right.points + 2.0)
    show(views, [left, flipped])
    views[1].clearer = right
    found = find(finder, 0)
    assert found.views[1] is right
    assert views[1].kept is right
    assert (len(views[0].retries), len(views[1].retries)) == (0, 1)
    find(finder, 1)
    assert views[1].retries[0] != views[1].retries[1]


def test_no_view_looks_again_between_two_exposures(pair):
    finder, views = pair
    left, right = seen()
    show(views, [replace(left, right=0.1), replace(right, right=0.1)])
    find(finder, 1, weight=0.5)
    assert (len(views[0].retries), len(views[1].retries)) == (1, 0)


def test_another_crop_that_no_longer_agrees_is_not_taken(pair):
    finder, views = pair
    left, right = seen()
    flipped = replace(right, right=0.1)
    show(views, [left, flipped])
    views[1].clearer = seen(ELSEWHERE)[1]
    found = find(finder, 0)
    assert found.views[1] is flipped


def test_only_so_many_crops_are_run_again_in_one_instant():
    views = scripted_views(THREE)
    hands = seen_by_all(THREE, HAND, right=0.1)
    show(views, hands)
    HandFinder(THREE, views).find(instant(0, 3), anyone, quickly=False)
    assert sum(len(view.retries) for view in views) == MOST_RETRIES


def test_a_left_arms_hand_is_not_looked_at_again():
    views = scripted_views(PAIR_RIG, right_arm=False)
    show(views, seen(right=0.05))
    assert isinstance(find(HandFinder(PAIR_RIG, views), 0), SeenHand)
    assert all(view.retries == [] for view in views)


def test_a_third_view_that_has_lost_it_does_not_matter():
    views = scripted_views(THREE)
    finder = HandFinder(THREE, views)
    hands = seen_by_all(THREE, HAND)
    for k in range(4):
        show(views, hands)
        views[k % 3].shown = []
        found = find(finder, k, cameras=3)
        assert set(found.views) == {0, 1, 2} - {k % 3}
        np.testing.assert_allclose(found.points, HAND, atol=1e-4)


@pytest.mark.parametrize("times", [(0, 0, 0), (5, 4, 3), (0, 10**12, 10**12 + 1)])
def test_clocks_that_stand_still_or_jump_do_not_matter(pair, times):
    finder, views = pair
    show(views, seen())
    for t_ns in times:
        views_now = replace(instant(0), t_ns=t_ns)
        assert is_at(finder.find(views_now, anyone, quickly=False), (0.0, 0.0, 0.0))


def asked(finder, views, motion, instants=6, weight=1.0):
    """By instant, which views look at their pictures."""
    found = []
    for k in range(instants):
        before = [view.looks for view in views]
        assert isinstance(finder.find(instant(k, 2, weight), anyone, quickly=True, motion=motion), SeenHand)
        found.append([n for n, view in enumerate(views) if view.looks > before[n]])
    return found


def test_the_views_look_in_turn_at_a_hand_whose_motion_is_known(pair):
    finder, views = pair
    show(views, seen())
    looks = asked(finder, views, (HAND, HAND))
    assert looks[0] == [0, 1]
    assert all(len(looked) == 1 for looked in looks[1:])
    assert all(one != other for one, other in pairwise(looks[1:]))


def test_all_views_look_without_a_known_motion_and_between_exposures(pair):
    finder, views = pair
    show(views, seen())
    assert asked(finder, views, None) == [[0, 1]] * 6
    looks = asked(finder, views, (HAND, HAND), weight=0.5)
    assert all(1 in looked for looked in looks)


def test_all_views_look_at_a_hand_that_they_are_not_sure_of(pair):
    finder, views = pair
    show(views, seen(score=0.3))
    assert asked(finder, views, (HAND, HAND)) == [[0, 1]] * 6


def test_a_view_that_does_not_look_moves_what_it_saw(pair):
    finder, views = pair
    now = moved(HAND, STEP)
    show(views, seen())
    asked(finder, views, None, instants=1)
    show(views, seen(STEP))
    found = finder.find(instant(1), anyone, quickly=True, motion=(HAND, now))
    assert [hand.carried for hand in found.views.values()].count(True) == 1
    assert is_at(found, STEP)
