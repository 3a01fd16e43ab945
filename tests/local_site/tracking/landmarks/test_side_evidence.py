"""A hand's side is decided early where it is clear, kept through flips of single views, and forgotten with it."""

import pytest

from local_site.tracking.landmarks.side_evidence import ENOUGH, ENOUGH_IF_CLEAR, REMEMBERED, SideEvidence

WRONG_RUN = 5  # the longest that a view was seen to take a hand for its mirror image
RIGHT, LEFT, FLIPPED_VIEW = 0.97, 0.03, 0.5  # one of two views that flips gives a mean of about a half


def evidence(*seen):
    side = SideEvidence()
    for right in seen:
        side.add(right)
    return side


def test_nothing_seen_is_undecided_and_supports_both_sides():
    side = SideEvidence()
    assert side.right is None
    assert side.supports(True)
    assert side.supports(False)


@pytest.mark.parametrize(("right", "is_right"), [(RIGHT, True), (LEFT, False)])
def test_a_clear_hand_is_decided_after_a_few_instants(right, is_right):
    assert evidence(*[right] * (ENOUGH_IF_CLEAR - 1)).right is None
    side = evidence(*[right] * ENOUGH_IF_CLEAR)
    assert side.right == pytest.approx(right)
    assert side.supports(is_right)
    assert not side.supports(not is_right)


@pytest.mark.parametrize(("right", "is_right"), [(0.7, True), (0.3, False)])
def test_an_unclear_hand_needs_more(right, is_right):
    assert evidence(*[right] * (ENOUGH - 1)).right is None
    assert evidence(*[right] * ENOUGH).supports(is_right)
    assert not evidence(*[right] * ENOUGH).supports(not is_right)


@pytest.mark.parametrize("wrong", [FLIPPED_VIEW, LEFT])
def test_a_hand_that_was_seen_well_survives_a_wrong_run(wrong):
    side = evidence(*[RIGHT] * REMEMBERED)
    for _ in range(WRONG_RUN):
        side.add(wrong)
        assert side.supports(True)


def test_a_left_hand_is_refused_though_views_flip_now_and_then():
    side = SideEvidence()
    for k in range(60):
        side.add(FLIPPED_VIEW if k % 4 == 3 else LEFT)
        assert k + 1 < ENOUGH or not side.supports(True)


def test_another_hand_is_noticed_though_it_is_not_said():
    side = evidence(*[RIGHT] * 50)
    for _ in range(REMEMBERED):
        side.add(LEFT)
    assert not side.supports(True)
    assert side.supports(False)


def test_it_can_be_forgotten():
    side = evidence(*[LEFT] * 20)
    side.forget()
    assert side.right is None
    assert side.supports(True)
