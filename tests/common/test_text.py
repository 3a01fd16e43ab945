"""Text from elsewhere: cut with an ellipsis, always valid, and nothing in it that acts on a terminal."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.text import cut, escaped


def test_what_is_cut_ends_with_an_ellipsis() -> None:
    assert cut("x" * 400, 400) == "x" * 400
    assert cut("x" * 401, 400) == "x" * 399 + "…"


@given(st.text(st.characters(categories=["Cs", "L", "N", "P", "Cc", "So"]), max_size=900), st.sampled_from([64, 400]))
def test_every_text_is_cut_to_valid_unicode_of_the_length(text: str, most: int) -> None:
    shown = cut(text, most)
    assert len(shown) <= most
    assert shown.encode().decode() == shown


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("α is 12° … – 3 µs", "α is 12° … – 3 µs"),
        ("\x1b[31mred\x07", r"\x1b[31mred\x07"),
        ("two\r\nlines", r"two\r\nlines"),
        ("\u202etxet \x9b \u2069", r"\u202etxet \x9b \u2069"),
        ("\ud800 no character", r"\ud800 no character"),
    ],
)
def test_only_what_is_not_shown_is_escaped(said: str, shown: str) -> None:
    assert escaped(said) == shown


@given(st.text())
def test_what_is_escaped_is_one_line_that_can_be_printed(text: str) -> None:
    assert escaped(text).isprintable()
    assert escaped(text).encode().decode() == escaped(text)
