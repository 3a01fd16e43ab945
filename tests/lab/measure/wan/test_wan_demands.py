"""The table of demands: which apply to which link, and what fails them."""

from typing import Any

import pytest

from lab.measure.wan.demands import judge_change, judge_links
from lab.measure.wan.links import CHANGES, MATRIX, SUBSET, WanLink

CALM, ROUGH = WanLink(80, mbit_s=5), WanLink(80, 0.2, 0.03, 5)
GOOD: dict[str, Any] = {
    "followed": 1.0,
    "holds_a_minute": 0.0,
    "latches": 0,
    "changes_in_a_second": 0,
    "error_mm": 1.0,
    "fps": 29.0,
    "age_p95_ms": 150.0,
    "ssim_below_jpeg": 0.01,
    "hand_p99_ms": 120.0,
}
CUT_300, CUT_1000, CUT_10000, NARROWED, FARTHER = CHANGES
HAND_MM_S = 70.0
UNMOVED: dict[str, Any] = {
    "followed_before": True,
    "held": True,
    "latched": False,
    "holds": 1,
    "followed_after_s": 0.5,
    "ready_after_s": 0.5,
    "moved_mrad": 0.0,
    "tool_mm_s": 100.0,
    "age_understated_ms": -2.0,
    "why": "",
}
LATCHED = UNMOVED | {"latched": True, "followed_after_s": None, "why": "ready: waiting to be engaged"}


def failed(link: WanLink, **different: Any) -> list[str]:
    measured = {CALM: GOOD, link: GOOD | different}
    return [one.demand for one in judge_links(measured) if not one.passed and one.where == link.name]


def test_the_matrix_has_no_link_twice_and_the_subset_is_part_of_it() -> None:
    assert len(set(MATRIX)) == len(MATRIX) == 108
    assert set(SUBSET) <= set(MATRIX)
    assert len({link.name for link in MATRIX}) == len(MATRIX)
    assert all(link.calm in SUBSET for link in SUBSET)  # the error of every rough link has one to compare with


def test_good_figures_meet_every_demand() -> None:
    assert all(one.passed for one in judge_links({CALM: GOOD, ROUGH: GOOD}))


@pytest.mark.parametrize(
    ("different", "demand"),
    [
        ({"followed": 0.99}, "followed ≥ 0.995"),
        ({"holds_a_minute": 2.1}, "holds_a_minute ≤ 2"),
        ({"latches": 1}, "latches ≤ 0"),
        ({"changes_in_a_second": 3}, "changes_in_a_second ≤ 2"),
        ({"error_mm": 1.21}, "error_mm ≤ 1.2"),
        ({"error_mm": None}, "error_mm ≤ 1.2"),
        ({"error_mm": float("nan")}, "error_mm ≤ 1.2"),
    ],
)
def test_each_demand_on_a_rough_link_fails_alone(different: dict[str, Any], demand: str) -> None:
    assert failed(ROUGH, **different) == [demand]


def test_pictures_are_demanded_by_rate_and_not_where_packets_are_lost() -> None:
    poor = {"fps": 10.0, "age_p95_ms": 400.0, "ssim_below_jpeg": 0.05}
    assert failed(CALM, **poor) == ["fps ≥ 25", "age_p95_ms ≤ 200", "ssim_below_jpeg ≤ 0.02"]
    assert failed(WanLink(80, mbit_s=2), **poor) == ["fps ≥ 15", "age_p95_ms ≤ 280"]
    assert failed(ROUGH, **poor) == failed(WanLink(80, loss=0.01, mbit_s=2), **poor) == []


def test_a_narrow_link_need_not_follow_but_must_not_flicker() -> None:
    assert failed(WanLink(80, mbit_s=2), followed=0.2, holds_a_minute=30.0) == []
    assert failed(WanLink(80, mbit_s=2), changes_in_a_second=3) == ["changes_in_a_second ≤ 2"]


def test_the_hand_beside_the_pictures_is_compared_where_it_was_measured_alone() -> None:
    assert failed(CALM, hand_alone_p99_ms=100.0) == []
    assert failed(CALM, hand_alone_p99_ms=90.0) == ["hand_p99_ms ≤ 117"]


def test_a_figure_that_is_missing_fails() -> None:
    verdicts = judge_links({ROUGH: {"followed": 0.0, "why": "too old"}})
    assert not any(one.passed for one in verdicts)


@pytest.mark.parametrize(
    ("change", "figures", "different", "demand"),
    [
        (CUT_300, UNMOVED, {"held": False}, "held ≥ 1"),
        (CUT_1000, LATCHED, {"followed_before": False}, "followed_before ≥ 1"),
        (CUT_300, UNMOVED, {"latched": True}, "latched ≤ 0"),
        (CUT_300, UNMOVED, {"followed_after_s": 1.1}, "followed_after_s ≤ 1"),
        (CUT_1000, LATCHED, {"latched": False}, "latched ≥ 1"),
        (CUT_1000, LATCHED, {"ready_after_s": 1.1}, "ready_after_s ≤ 1"),
        (CUT_10000, LATCHED, {"ready_after_s": 2.1}, "ready_after_s ≤ 2"),
        (CUT_10000, LATCHED, {"moved_mrad": 0.1}, "moved_mrad ≤ 0"),
        (NARROWED, UNMOVED, {"holds": 2}, "holds ≤ 1"),
        (NARROWED, UNMOVED, {"age_understated_ms": 21.0}, "age_understated_ms ≤ 20"),
        (FARTHER, UNMOVED, {"tool_mm_s": 121.0}, "tool_mm_s ≤ 120"),
        (FARTHER, UNMOVED, {"followed_after_s": 2.1}, "followed_after_s ≤ 2, or says why not"),
        (FARTHER, UNMOVED, {"followed_after_s": None}, "followed_after_s ≤ 2, or says why not"),
        (FARTHER, UNMOVED, {"followed_after_s": 5.0, "why": "late"}, "followed_after_s ≤ 2, or says why not"),
    ],
)
def test_each_demand_on_a_change_fails_alone(change: Any, figures: Any, different: Any, demand: str) -> None:
    assert all(one.passed for one in judge_change(change, figures, HAND_MM_S))
    verdicts = judge_change(change, figures | different, HAND_MM_S)
    assert [one.demand for one in verdicts if not one.passed] == [demand]


def test_a_cut_that_is_shorter_than_the_age_limit_need_not_hold_the_arm() -> None:
    through = UNMOVED | {"held": False, "age_limit_before_ms": 300.0}
    assert all(one.passed for one in judge_change(CUT_300, through, HAND_MM_S))
    assert not all(one.passed for one in judge_change(CUT_300, through | {"age_limit_before_ms": 275.0}, HAND_MM_S))


def test_an_arm_that_says_why_it_does_not_follow_is_excused_after_a_lasting_change_only() -> None:
    says = UNMOVED | {"followed_after_s": None, "why": "the link takes 310 ms"}
    assert all(one.passed for one in judge_change(FARTHER, says, HAND_MM_S))
    assert not all(one.passed for one in judge_change(CUT_300, says, HAND_MM_S))
