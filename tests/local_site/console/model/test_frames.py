"""Frames for a page: the newest of each view, no more in flight than it paints, and all views in turn."""

from hypothesis import given
from hypothesis import strategies as st

from local_site.console.model.frames import IN_FLIGHT, MOST_WAITING, FrameSlots, ViewFrame

VIEWS = ("a", "b", "c", "d")


def frame(view: str, seq: int, *, key: bool = True) -> ViewFrame:
    return ViewFrame(view, seq, True, key, b"")


def test_a_newer_frame_replaces_the_one_that_waits() -> None:
    slots = FrameSlots()
    for seq in range(3):
        slots.offer(frame("a", seq))
    taken = slots.take()
    assert taken is not None
    assert taken.seq == 2
    assert slots.take() is None


def test_a_page_that_paints_nothing_gets_only_so_many() -> None:
    slots = FrameSlots()
    sent = 0
    for seq in range(50):
        slots.offer(frame("a", seq))
        sent += slots.take() is not None
    assert sent == IN_FLIGHT
    slots.taken("a")
    newest = slots.take()
    assert newest is not None
    assert newest.seq == 49


def test_a_slow_view_does_not_hold_up_the_others() -> None:
    slots = FrameSlots()
    for seq in range(IN_FLIGHT):
        slots.offer(frame("a", seq))
        assert slots.take() is not None
    slots.offer(frame("a", 9))
    slots.offer(frame("b", 1))
    taken = slots.take()
    assert taken is not None
    assert taken.view == "b"


def test_views_take_turns() -> None:
    slots, order = FrameSlots(), []
    for seq in range(3):
        for view in VIEWS:
            slots.offer(frame(view, seq))
        while (taken := slots.take()) is not None:
            order.append(taken.view)
            slots.taken(taken.view)
    assert order == list(VIEWS) * 3


def test_more_said_to_be_taken_than_was_sent_gives_no_credit() -> None:
    slots = FrameSlots()
    for _ in range(10):
        slots.taken("a")
    sent = 0
    for seq in range(9):
        slots.offer(frame("a", seq))
        sent += slots.take() is not None
    assert sent == IN_FLIGHT


@given(st.lists(st.tuples(st.sampled_from(["offer", "take", "taken"]), st.sampled_from(VIEWS))))
def test_never_more_in_flight_and_never_an_older_frame(steps: list[tuple[str, str]]) -> None:
    slots = FrameSlots()
    flying, newest = dict.fromkeys(VIEWS, 0), dict.fromkeys(VIEWS, -1)
    for seq, (step, view) in enumerate(steps):
        if step == "offer":
            slots.offer(frame(view, seq))
        elif step == "taken" and flying[view]:
            flying[view] -= 1
            slots.taken(view)
        elif (sent := slots.take()) is not None:
            flying[sent.view] += 1
            assert flying[sent.view] <= IN_FLIGHT
            assert sent.seq > newest[sent.view]
            newest[sent.view] = sent.seq


def sent(slots: FrameSlots, *, painted: bool = True) -> list[int]:
    """The numbers of what goes out now; what is painted makes room for more."""
    numbers = []
    while (taken := slots.take()) is not None:
        numbers.append(taken.seq)
        if painted:
            slots.taken(taken.view)
    return numbers


def test_pictures_that_need_one_another_all_go_out_in_order() -> None:
    slots = FrameSlots()
    assert all(slots.offer(frame("a", seq, key=seq == 0)) for seq in range(9))
    assert sent(slots) == list(range(9))


def test_a_key_frame_replaces_all_that_wait() -> None:
    slots = FrameSlots()
    for seq in range(9):
        slots.offer(frame("a", seq, key=seq in {0, 6}))
    assert sent(slots) == [6, 7, 8]


def test_after_a_gap_nothing_goes_to_a_page_until_a_key_frame() -> None:
    slots = FrameSlots()
    taken = [slots.offer(frame("a", seq, key=seq in {0, 7})) for seq in (0, 1, 3, 4, 7, 8)]
    assert taken == [True, True, False, False, True, True]
    assert sent(slots) == [7, 8]


def test_a_gap_is_told_until_a_key_frame_comes() -> None:
    slots = FrameSlots()
    assert slots.wants_after("a") is None
    wanted = []
    for seq in (3, 4, 5, 6):
        slots.offer(frame("a", seq, key=seq == 5))
        wanted.append(slots.wants_after("a"))
    assert wanted == [3, 4, None, None]


def test_a_page_that_falls_behind_gets_nothing_old_and_needs_a_key_frame() -> None:
    slots = FrameSlots()
    for seq in range(IN_FLIGHT):
        slots.offer(frame("a", seq, key=seq == 0))
    assert sent(slots, painted=False) == list(range(IN_FLIGHT))
    last = IN_FLIGHT + MOST_WAITING
    offered = [slots.offer(frame("a", seq, key=False)) for seq in range(IN_FLIGHT, last + 1)]
    assert offered == [True] * MOST_WAITING + [False]
    assert slots.wants_after("a") == last
    slots.taken("a")
    assert sent(slots) == []
    slots.offer(frame("a", last + 1, key=True))
    assert sent(slots) == [last + 1]


def test_what_a_page_could_not_decode_needs_a_key_frame_for_that_view_alone() -> None:
    slots = FrameSlots()
    for view in ("a", "b"):
        slots.offer(frame(view, 0))
        slots.offer(frame(view, 1, key=False))
    slots.interrupt("a")
    assert (slots.wants_after("a"), slots.wants_after("b")) == (1, None)
    assert not slots.offer(frame("a", 2, key=False))
    assert slots.offer(frame("b", 2, key=False))
    slots.interrupt("nobody")
