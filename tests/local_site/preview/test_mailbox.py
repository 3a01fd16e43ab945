"""A message in the box is whole, is taken once, and is never waited for."""

import os
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from local_site.preview.mailbox import MAX_PARTS, Mailbox
from tests.present import present

SECOND_NS = 1_000_000_000


@given(st.lists(st.binary(max_size=300), min_size=1, max_size=MAX_PARTS))
def test_what_is_put_is_taken(parts):
    box = Mailbox(4096)
    assert box.is_free
    assert box.put(parts)
    assert not box.is_free
    assert [part.tobytes() for part in box.take()] == parts
    assert box.take() is None


def test_pictures_of_any_layout_come_as_their_pixels():
    picture = np.arange(24, dtype=np.uint8).reshape(4, 6)
    box = Mailbox(100)
    assert box.put([picture, picture[:, ::2]])
    whole, thinned = present(box.take())
    assert (whole.reshape(4, 6) == picture).all()
    assert (thinned.reshape(4, 3) == picture[:, ::2]).all()


def test_a_second_message_waits_for_nobody_and_harms_nothing():
    box = Mailbox(100)
    assert box.put([b"first"])
    assert not box.put([b"second"])
    assert present(box.take())[0].tobytes() == b"first"
    assert box.put([b"third"])


@pytest.mark.parametrize("parts", [[bytes(101)], [bytes(60), bytes(60)], [b"x"] * (MAX_PARTS + 1)])
def test_what_does_not_fit_is_refused(parts):
    box = Mailbox(100)
    assert not box.put(parts)
    assert box.is_free


def test_another_process_is_woken_and_answers():
    there, back = Mailbox(1000), Mailbox(1000)
    if os.fork() == 0:
        there.wait(10 * SECOND_NS)
        back.put([part.tobytes()[::-1] for part in there.take() or [np.zeros(0, np.uint8)]])
        os._exit(0)
    there.put([b"abc", b"def"])
    back.wait(10 * SECOND_NS)
    os.wait()
    assert [part.tobytes() for part in present(back.take())] == [b"cba", b"fed"]


def test_waiting_ends():
    box = Mailbox(10)
    before = time.monotonic()
    box.wait(SECOND_NS // 100)
    assert time.monotonic() > before
    assert box.take() is None
