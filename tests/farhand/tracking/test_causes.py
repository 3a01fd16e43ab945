"""The cause that the closing line of a track names: that of the most pairs, in however many words the pairs told it."""

import pytest

from farhand.tracking.causes import Causes
from local_site.tracking.foreground.reasons import ForegroundReason
from local_site.tracking.tracker import TrackingReason

GREY, CUT = ForegroundReason.NO_COLOUR, "the hand is cropped by the border"
NO_FOREARM = "no forearm can be made out; hold the arm bent and across the view"


def commonest(reasons):
    causes = Causes(["left", "right"])
    for reason in reasons:
        causes.add(reason)
    return causes.commonest


def test_a_cause_that_one_camera_names_now_and_then_the_other_counts_as_one():
    grey = [f"left: {GREY}", f"right: {GREY}", f"left: {GREY}; right: {GREY}"]
    assert commonest([TrackingReason.NO_HAND] * 2 + grey) == f"left and right: {GREY}"


def test_a_pair_in_which_both_cameras_name_a_cause_counts_once():
    assert commonest([f"left: {GREY}; right: {GREY}"] + [TrackingReason.NO_HAND] * 2) == TrackingReason.NO_HAND


def test_only_the_cameras_that_name_the_cause_are_named():
    assert commonest([f"left: {GREY}; right: {CUT}", f"left: {GREY}"]) == f"left: {GREY}"


def test_a_cause_is_the_same_alone_and_with_the_progress_of_learning():
    lesson = [f"{TrackingReason.FOLDED}; {TrackingReason.LEARNING}", f"left: {CUT}; {TrackingReason.FOLDED}"]
    assert commonest([*lesson, f"right: {CUT}", f"left: {CUT}"]) == f"left and right: {CUT}"
    assert commonest([*lesson, TrackingReason.FOLDED]) == TrackingReason.FOLDED


@pytest.mark.parametrize("sentence", [*TrackingReason, f"right: {NO_FOREARM}"])
def test_a_sentence_with_a_semicolon_stays_whole(sentence):
    assert commonest([sentence]) == sentence
    assert commonest([f"left: {CUT}; {sentence}", sentence]) == sentence


def test_without_names_of_cameras_a_sentence_is_the_cause():
    causes = Causes(())
    causes.add(f"left: {CUT}")
    assert causes.commonest == f"left: {CUT}"
