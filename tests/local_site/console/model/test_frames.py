"""Frames for a page: the newest of each view, no more in flight than it paints, and all views in turn."""

from hypothesis import given
from hypothesis import strategies as st

from local_site.console.model.frames import IN_FLIGHT, FrameSlots, ViewFrame

VIEWS = ("a", "b", "c", "d")


def frame(view: str, seq: int) -> ViewFrame:
    return ViewFrame(view, seq, b"")


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
