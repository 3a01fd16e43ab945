"""Which links a command chooses."""

import pytest

from lab.measure.wan.links import CHANGES, MATRIX, SUBSET, WanLink, chosen


def test_a_part_is_chosen_unless_all_are_asked_for() -> None:
    assert chosen([]) == (SUBSET, CHANGES)
    assert chosen(["--full"]) == (MATRIX, CHANGES)


def test_links_and_changes_are_chosen_by_name() -> None:
    links, changes = chosen(["--links=120ms_20pc_3pc_5mbit,cut of 1 s"])
    assert links == (WanLink(120, jitter=0.2, loss=0.03, mbit_s=5),)
    assert [change.name for change in changes] == ["cut of 1 s"]


def test_an_unknown_name_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(ValueError, match=r"called 7ms: .*cut of 1 s"):
        chosen(["--links=7ms"])
