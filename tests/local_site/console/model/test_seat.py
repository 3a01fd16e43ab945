"""Who operates, and what counts as held: silence, stops and another page always need a new press."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import ClutchKey
from local_site.console.model.seat import Seat, Visitor

ANNA, BEN = Visitor(1, "127.0.0.1"), Visitor(2, "10.0.0.7")
BEAT_NS = 50 * NS_PER_MS
UP, DOWN, UNSEEN = ClutchKey


class Room:
    """A seat with its clock; `press` and `rest` beat as a page does."""

    def __init__(self) -> None:
        self.seat, self.now_ns = Seat(open_=True), 10 * NS_PER_S
        self.seat.arrive(ANNA, self.now_ns)

    def beats(self, count: int, *, down: bool, by: Visitor = ANNA, heard_ms_ago: float | None = 50.0) -> bool:
        for _ in range(count):
            self.now_ns += BEAT_NS
            heard_ns = self.now_ns - round(heard_ms_ago * NS_PER_MS) if heard_ms_ago is not None else None
            self.seat.beat(by, self.now_ns, heard_ns, down=down)
        return self.seat.held(self.now_ns)

    def pass_ms(self, milliseconds: float) -> bool:
        self.now_ns += round(milliseconds * NS_PER_MS)
        return self.seat.held(self.now_ns)


@pytest.fixture
def room() -> Room:
    return Room()


def test_the_first_page_operates_and_the_second_is_told_so(room: Room) -> None:
    room.seat.arrive(BEN, room.now_ns)
    assert room.seat.occupant == ANNA
    refused = room.seat.take(BEN, room.now_ns)
    assert not refused.done
    assert "page 1 (127.0.0.1) operates" in refused.sentence


def test_where_nobody_may_operate_nobody_gets_the_seat() -> None:
    seat = Seat(open_=False)
    seat.arrive(ANNA, 0)
    refused = seat.take(ANNA, 0)
    assert not refused.done
    assert "only watches" in refused.sentence
    assert seat.occupant is None


def test_a_page_that_is_silent_keeps_the_seat_for_five_seconds(room: Room) -> None:
    assert not room.seat.take(BEN, room.now_ns + 5 * NS_PER_S).done
    assert room.seat.take(BEN, room.now_ns + 5 * NS_PER_S + 1).done
    assert room.seat.occupant == BEN


def test_a_press_counts_after_the_key_was_seen_up(room: Room) -> None:
    assert not room.beats(5, down=True)
    room.beats(1, down=False)
    assert room.beats(5, down=True)
    assert not room.beats(1, down=False)


def test_a_silent_page_holds_for_200_ms_and_then_needs_a_new_press(room: Room) -> None:
    room.beats(1, down=False)
    room.beats(1, down=True)
    assert room.pass_ms(200)
    assert not room.pass_ms(1)
    assert not room.beats(10, down=True)
    room.beats(1, down=False)
    assert room.beats(1, down=True)


@pytest.mark.parametrize("heard_ms_ago", [401.0, 3000.0])
def test_beats_that_all_come_late_count_as_silence_and_then_need_a_new_press(room: Room, heard_ms_ago: float) -> None:
    room.beats(1, down=False)
    room.beats(1, down=True)
    room.beats(5, down=False, heard_ms_ago=heard_ms_ago)
    assert not room.beats(5, down=True, heard_ms_ago=heard_ms_ago)
    assert not room.seat.reports(room.now_ns)
    assert room.seat.late(room.now_ns)
    assert not room.beats(5, down=True)
    room.beats(1, down=False)
    assert room.beats(1, down=True, heard_ms_ago=350.0)
    assert room.seat.reports(room.now_ns)
    assert not room.seat.late(room.now_ns)


def test_a_page_that_never_hears_the_console_holds_no_longer_than_400_ms(room: Room) -> None:
    room.beats(1, down=False, heard_ms_ago=None)
    assert room.beats(7, down=True, heard_ms_ago=None)
    assert not room.beats(1, down=True, heard_ms_ago=None)
    assert room.seat.late(room.now_ns)


def test_what_was_heard_in_the_future_is_heard_now(room: Room) -> None:
    room.beats(1, down=False)
    assert room.beats(1, down=True, heard_ms_ago=-1e6)
    assert not room.pass_ms(201)


@given(st.lists(st.tuples(st.floats(0, 1500), st.floats(0, 1500)), min_size=60, max_size=60), st.integers(2, 40))
def test_whatever_the_way_does_a_key_is_held_for_400_ms_after_its_release_at_most(
    delays_ms: list[tuple[float, float]], released_at: int
) -> None:
    """Beats every 50 ms and their echoes, in order, each with another delay; the key is down until it is released."""
    seat, heard_ms, arrives_ms, echoed_ms = Seat(open_=True), None, 0.0, 0.0
    echoes: list[tuple[float, float]] = []  # when it comes, and what it says
    beats: list[tuple[float, float | None, bool]] = []
    seat.arrive(ANNA, 0)
    for k, (there_ms, back_ms) in enumerate(delays_ms):
        sent_ms = 50.0 * k
        heard_ms = max((says for comes, says in echoes if comes <= sent_ms), default=None)
        arrives_ms = max(arrives_ms, sent_ms + there_ms)
        echoed_ms = max(echoed_ms, arrives_ms + back_ms)
        echoes.append((echoed_ms, arrives_ms))
        beats.append((arrives_ms, heard_ms, 1 <= k < released_at))
    last_ms = 50.0 * released_at + 400.0
    for now_ms in sorted({*(arrives for arrives, _, _ in beats), *np.arange(0.0, 5000.0, 10.0)}):
        for arrives, heard, down in beats:
            if arrives == now_ms:
                heard_ns = round(heard * NS_PER_MS) if heard is not None else None
                seat.beat(ANNA, round(now_ms * NS_PER_MS), heard_ns, down=down)
        assert now_ms <= last_ms or not seat.held(round(now_ms * NS_PER_MS))


def test_a_page_reports_while_it_operates_and_beats(room: Room) -> None:
    assert room.seat.reports(room.now_ns + 200 * NS_PER_MS)
    room.beats(1, down=False)
    room.beats(4, down=False, by=BEN)
    assert room.seat.reports(room.now_ns)
    assert not room.seat.reports(room.now_ns + 1)
    room.beats(1, down=False)
    assert room.seat.reports(room.now_ns)
    room.seat.leave(ANNA)
    assert not room.seat.reports(room.now_ns)


def test_a_silence_that_ends_with_a_beat_is_noticed_without_being_looked_at(room: Room) -> None:
    room.beats(1, down=False)
    room.beats(1, down=True)
    room.now_ns += 300 * NS_PER_MS
    assert not room.beats(3, down=True)


def test_after_a_stop_the_key_has_to_be_pressed_anew(room: Room) -> None:
    room.beats(1, down=False)
    assert room.beats(1, down=True)
    room.seat.interrupt()
    assert not room.beats(5, down=True)
    room.beats(1, down=False)
    assert room.beats(1, down=True)


def test_a_watching_page_holds_nothing(room: Room) -> None:
    room.seat.arrive(BEN, room.now_ns)
    room.beats(1, down=False, by=BEN)
    assert not room.beats(5, down=True, by=BEN)


@pytest.mark.parametrize("way", ["leave", "silence"])
def test_another_page_takes_an_empty_or_abandoned_seat_with_its_key_up(room: Room, way: str) -> None:
    room.beats(1, down=False)
    room.beats(1, down=True)
    if way == "leave":
        room.seat.leave(ANNA)
    else:
        room.now_ns += 5 * NS_PER_S + 1
    assert room.seat.take(BEN, room.now_ns).done
    assert room.seat.occupant == BEN
    assert not room.beats(5, down=True, by=BEN)
    room.beats(1, down=False, by=BEN)
    assert room.beats(1, down=True, by=BEN)
    assert room.beats(1, down=False, by=ANNA)


def test_an_empty_seat_holds_nothing() -> None:
    seat = Seat(open_=True)
    assert not seat.held(NS_PER_S)
    assert not seat.reports(NS_PER_S)


def test_a_page_that_gives_up_its_seat_is_told_so(room: Room) -> None:
    answer = room.seat.leave(ANNA)
    assert (answer.done, answer.sentence) == (True, "this page only watches")


def test_a_page_that_opens_after_an_operator_has_left_does_not_operate_until_it_asks(room: Room) -> None:
    room.seat.leave(ANNA)
    room.seat.arrive(BEN, room.now_ns)
    assert room.seat.occupant is None
    assert room.seat.take(BEN, room.now_ns).done
    room.seat.go(BEN)
    room.seat.arrive(ANNA, room.now_ns)  # a page that was closed, or is loaded again, has given up nothing
    assert room.seat.occupant == ANNA


def test_the_end_of_a_watching_page_leaves_the_operator(room: Room) -> None:
    assert room.seat.leave(BEN).done
    room.seat.go(BEN)
    assert room.seat.occupant == ANNA


def test_a_console_that_only_watches_gives_no_seat() -> None:
    seat = Seat(open_=False)
    seat.arrive(ANNA, NS_PER_S)
    assert seat.occupant is None
    assert "operate = false" in seat.take(ANNA, NS_PER_S).sentence


def test_what_the_operating_page_asks_the_robot_for_lasts_as_long_as_it_beats() -> None:
    seat, operates, watches = Seat(open_=True), Visitor(1, "a"), Visitor(2, "b")
    seat.arrive(operates, 0)
    seat.beat(operates, 0, 0, down=False, assist="block")
    seat.beat(watches, 0, 0, down=False, assist="shelf")
    assert seat.assisted(200 * NS_PER_MS) == "block"
    assert seat.assisted(201 * NS_PER_MS) is None
    seat.beat(operates, 210 * NS_PER_MS, 200 * NS_PER_MS, down=False, assist="block")
    seat.leave(operates)
    assert seat.assisted(220 * NS_PER_MS) is None


def clutch(
    room: Room,
    key: ClutchKey,
    count: int = 1,
    *,
    by: Visitor = ANNA,
    heard_ms_ago: float = 50.0,
    after_ms: float = 50.0,
) -> ClutchKey:
    """So many beats with the clutch like this; what the console passes on then."""
    for _ in range(count):
        room.now_ns += round(after_ms * NS_PER_MS)
        heard_ns = room.now_ns - round(heard_ms_ago * NS_PER_MS)
        room.seat.beat(by, room.now_ns, heard_ns, down=False, clutch=key)
    return room.seat.clutch(room.now_ns)


def test_the_clutch_is_as_the_operating_page_reports_it_from_its_first_beat(room: Room) -> None:
    assert room.seat.clutch(room.now_ns) is UP
    assert clutch(room, DOWN) is DOWN
    assert clutch(room, DOWN, 40) is DOWN
    assert clutch(room, UP) is UP


@pytest.mark.parametrize(
    "interrupted",
    [
        lambda room: room.pass_ms(201),
        lambda room: clutch(room, UP, after_ms=201),
        lambda room: clutch(room, UP, heard_ms_ago=401),
        lambda room: clutch(room, UP, 20, heard_ms_ago=3000),
        lambda room: clutch(room, UNSEEN),
        lambda room: (room.seat.go(ANNA), room.seat.arrive(ANNA, room.now_ns)),
        lambda room: (
            (room.seat.leave(ANNA), room.seat.take(BEN, room.now_ns), room.seat.leave(BEN))
            and room.seat.take(ANNA, room.now_ns)
        ),
    ],
    ids=["silent", "silent, then up", "late", "late for long", "not seen", "loaded again", "another page between"],
)
def test_a_release_that_does_not_come_in_time_from_the_same_page_lets_nothing_go(
    room: Room, interrupted: Callable[[Room], object]
) -> None:
    clutch(room, DOWN, 3)
    interrupted(room)
    assert room.seat.clutch(room.now_ns) is UNSEEN
    assert clutch(room, UP, 20) is UNSEEN
    assert clutch(room, DOWN) is DOWN
    assert clutch(room, UP) is UP


def test_a_second_page_neither_clutches_nor_lets_go(room: Room) -> None:
    room.seat.arrive(BEN, room.now_ns)
    clutch(room, UP)
    assert clutch(room, DOWN, by=BEN) is UP
    clutch(room, DOWN)
    assert clutch(room, UP, by=BEN) is DOWN
    room.seat.leave(BEN)
    assert room.seat.clutch(room.now_ns) is DOWN


def test_a_press_that_comes_late_holds_all_the_same(room: Room) -> None:
    clutch(room, UP)
    assert clutch(room, DOWN, heard_ms_ago=500) is UNSEEN


def test_a_stop_lets_go_of_the_key_and_not_of_the_clutch(room: Room) -> None:
    clutch(room, DOWN)
    room.seat.interrupt()
    assert clutch(room, DOWN) is DOWN
