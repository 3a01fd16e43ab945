"""What is under way arrives at its time, and overtakes only where it may."""

import pytest

from lab.stage.network.in_transit import InTransit


@pytest.mark.parametrize(("in_order", "by_20_ns", "by_30_ns"), [(True, [], ["a", "b"]), (False, ["b"], ["a"])])
def test_what_is_sent_later_over_a_shorter_way_overtakes_only_where_it_may(
    in_order: bool, by_20_ns: list[str], by_30_ns: list[str]
) -> None:
    under_way = InTransit[str](in_order)
    under_way.send("a", 30)
    under_way.send("b", 20)
    assert under_way.next_ns == (30 if in_order else 20)
    assert under_way.arrived(20) == by_20_ns
    assert under_way.arrived(30) == by_30_ns
    assert under_way.next_ns is None


def test_what_arrives_at_once_arrives_in_the_order_in_which_it_was_sent() -> None:
    under_way = InTransit[str](in_order=False)
    for each in "cab":
        under_way.send(each, 10)
    assert under_way.arrived(9) == []
    assert under_way.arrived(10) == ["c", "a", "b"]
