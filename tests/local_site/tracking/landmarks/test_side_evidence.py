"""A hand's side is decided early where it is clear, kept through flips of single views, and forgotten with it."""

import pytest

from local_site.tracking.landmarks.side_evidence import ENOUGH, ENOUGH_IF_CLEAR, REMEMBERED, SideEvidence

WRONG_RUN = 5  # the longest that a view was seen to take a hand for its mirror image
OWN, OTHER, FLIPPED_VIEW = 0.97, 0.03, 0.5  # one of two views that flips gives a mean of about a half


def evidence(*seen):
    side = SideEvidence()
    for for_side in seen:
        side.add(for_side)
    return side


def test_nothing_seen_is_undecided():
    side = SideEvidence()
    assert not side.is_sure
    assert not side.is_other


def test_a_clear_hand_is_decided_after_a_few_instants():
    assert not evidence(*[OWN] * (ENOUGH_IF_CLEAR - 1)).is_sure
    assert evidence(*[OWN] * ENOUGH_IF_CLEAR).is_sure
    assert not evidence(*[OTHER] * (ENOUGH_IF_CLEAR - 1)).is_other
    assert evidence(*[OTHER] * ENOUGH_IF_CLEAR).is_other


def test_an_unclear_hand_needs_more():
    assert not evidence(*[0.7] * (ENOUGH - 1)).is_sure
    assert evidence(*[0.7] * ENOUGH).is_sure


def test_a_hand_that_could_be_either_is_never_sure():
    side = evidence(*[0.5] * 100)
    assert not side.is_sure
    assert not side.is_other


@pytest.mark.parametrize("wrong", [FLIPPED_VIEW, OTHER])
def test_a_hand_that_was_seen_well_survives_a_wrong_run(wrong):
    side = evidence(*[OWN] * REMEMBERED)
    for _ in range(WRONG_RUN):
        side.add(wrong)
        assert side.is_sure
        assert not side.is_other


def test_the_other_hand_is_never_sure_though_views_flip_now_and_then():
    side = SideEvidence()
    for k in range(60):
        side.add(FLIPPED_VIEW if k % 4 == 3 else OTHER)
        assert not side.is_sure
        assert side.is_other == (k + 1 >= ENOUGH_IF_CLEAR)


def test_another_hand_is_noticed_though_it_is_not_said():
    side = evidence(*[OWN] * 50)
    for _ in range(REMEMBERED):
        side.add(OTHER)
    assert side.is_other
    assert not side.is_sure


def test_it_can_be_forgotten():
    side = evidence(*[OTHER] * 20)
    side.forget()
    assert not side.is_other
    assert not side.is_sure
