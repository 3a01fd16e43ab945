"""Who operates, and what counts as held: silence, stops and another page always need a new press."""

import pytest

from common.clock import NS_PER_MS, NS_PER_S
from local_site.console.model.seat import Seat, Visitor

ANNA, BEN = Visitor(1, "127.0.0.1"), Visitor(2, "10.0.0.7")
BEAT_NS = 50 * NS_PER_MS


class Room:
    """A seat with its clock; `press` and `rest` beat as a page does."""

    def __init__(self) -> None:
        self.seat, self.now_ns = Seat(open_=True), 10 * NS_PER_S
        self.seat.arrive(ANNA, self.now_ns)

    def beats(self, count: int, *, down: bool, by: Visitor = ANNA) -> bool:
        for _ in range(count):
            self.now_ns += BEAT_NS
            self.seat.beat(by, self.now_ns, down=down)
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


def test_the_end_of_a_watching_page_leaves_the_operator(room: Room) -> None:
    assert room.seat.leave(BEN).done
    assert room.seat.occupant == ANNA


def test_a_console_that_only_watches_gives_no_seat() -> None:
    seat = Seat(open_=False)
    seat.arrive(ANNA, NS_PER_S)
    assert seat.occupant is None
    assert "operate = false" in seat.take(ANNA, NS_PER_S).sentence


def test_what_the_operating_page_asks_the_robot_for_lasts_as_long_as_it_beats() -> None:
    seat, operates, watches = Seat(open_=True), Visitor(1, "a"), Visitor(2, "b")
    seat.arrive(operates, 0)
    seat.beat(operates, 0, down=False, assist="block")
    seat.beat(watches, 0, down=False, assist="shelf")
    assert seat.assisted(200 * NS_PER_MS) == "block"
    assert seat.assisted(201 * NS_PER_MS) is None
    seat.beat(operates, 210 * NS_PER_MS, down=False, assist="block")
    seat.leave(operates)
    assert seat.assisted(220 * NS_PER_MS) is None
