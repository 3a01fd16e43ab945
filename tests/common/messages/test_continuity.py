"""After a gap no picture counts as whole until a key frame."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.messages.continuity import Continuity

KEY, DELTA, STATUS = "key", "delta", "status"


def take(continuity: Continuity, seq: int, kind: str) -> bool:
    return continuity.take(seq, is_picture=kind != STATUS, key=kind == KEY)


@pytest.mark.parametrize(
    ("messages", "taken", "wants_after"),
    [
        ([(0, KEY), (1, DELTA), (2, DELTA)], [True, True, True], None),
        ([(4, DELTA), (5, DELTA)], [False, False], 5),
        ([(4, DELTA), (5, KEY), (6, DELTA)], [False, True, True], None),
        ([(0, KEY), (1, DELTA), (3, DELTA), (4, DELTA)], [True, True, False, False], 4),
        ([(0, KEY), (2, DELTA), (5, KEY), (6, DELTA)], [True, False, True, True], None),
        ([(0, KEY), (1, STATUS), (2, DELTA)], [True, True, True], None),
        ([(0, KEY), (2, STATUS), (3, DELTA)], [True, True, False], 3),
        ([(0, KEY), (1, DELTA), (1, DELTA), (2, DELTA)], [True, True, False, False], 2),
        ([(7, STATUS), (12, STATUS)], [True, True], None),
        ([(7, KEY), (0, DELTA), (1, KEY)], [True, False, True], None),
    ],
)
def test_what_is_taken_and_what_is_asked_for(
    messages: list[tuple[int, str]], taken: list[bool], wants_after: int | None
) -> None:
    continuity = Continuity()
    assert [take(continuity, *message) for message in messages] == taken
    assert continuity.wants_after == wants_after


def test_what_is_lost_after_all_needs_a_key_frame_too() -> None:
    continuity = Continuity()
    take(continuity, 3, KEY)
    continuity.interrupt()
    assert continuity.wants_after == 3
    assert not take(continuity, 4, DELTA)
    assert continuity.wants_after == 4
    assert take(continuity, 5, KEY)
    assert take(continuity, 6, DELTA)


@given(st.lists(st.tuples(st.integers(0, 2), st.sampled_from([KEY, DELTA, STATUS])), max_size=60))
def test_every_picture_taken_has_all_since_a_key_frame_before_it(steps: list[tuple[int, str]]) -> None:
    continuity, seq, whole_up_to = Continuity(), 0, -1
    for lost, kind in steps:
        seq += 1 + lost
        took = take(continuity, seq, kind)
        if kind == KEY or (whole_up_to == seq - 1 and whole_up_to >= 0):
            whole_up_to = seq
        assert took == (whole_up_to == seq or kind == STATUS)
