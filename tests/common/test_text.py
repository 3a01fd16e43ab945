"""Text from elsewhere: cut with an ellipsis, always valid, and nothing in it that acts on a terminal."""

import tomllib
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from common.errors import ConfigError
from common.text import cut, escaped, file_name, in_xml_comment, instead_of, name_mistake, toml_string

HOSTILE = "x\"]\n[links]\ncontrol = 'tcp/0.0.0.0:7447' # \\ \u2028 \x85 \u202e \x00 \x7f \U000e0001 -->"


def test_a_name_that_is_none_of_these_is_answered_by_the_one_that_it_is_like_and_by_all() -> None:
    names = ["c500c", "franka", "kinematic"]
    assert instead_of("kinematik", names) == f"did you mean kinematic? Else choose one of: {', '.join(names)}"
    assert instead_of("elbow", names) == f"choose one of: {', '.join(names)}"


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


@given(st.text())
@example(HOSTILE)
def test_words_in_toml_read_as_themselves_and_a_comment_as_nothing(words: str) -> None:
    text = f"# {escaped(words)}\nkey = {toml_string(words)} # {escaped(words)}\n"
    assert tomllib.loads(text) == {"key": words}
    assert len(text.splitlines()) == 2


def test_what_is_no_unicode_is_refused_for_toml_with_the_cure() -> None:
    with pytest.raises(ConfigError, match=r"'a\\udcff' cannot stand in TOML; rename it, in UTF-8"):
        toml_string("a\udcff")


@given(st.text())
@example(HOSTILE)
@example("----->")
def test_words_in_a_comment_of_xml_stay_in_it(words: str) -> None:
    root = ElementTree.fromstring(f"<!-- {in_xml_comment(words)}\n--><a/>")  # noqa: S314  # made here
    assert (root.tag, len(root)) == ("a", 0)


@given(st.text())
@example("../../etc/passwd")
@example("/etc/passwd")
@example("..")
@example("")
@example(HOSTILE)
def test_a_files_name_stays_in_its_folder(words: str) -> None:
    name = file_name(words)
    assert Path("/folder", name).resolve().parent == Path("/folder")
    assert name.isprintable()
    assert not name.startswith(".")


def test_an_ordinary_files_name_stays_as_it_is() -> None:
    assert file_name("Unterarm links-2.STL") == "Unterarm links-2.STL"


@pytest.mark.parametrize("bad", ["\n", "\x00", "\x85", "\u2028", "\u202e", "\ud800"])
def test_a_name_with_what_does_not_show_is_refused_with_the_cure(bad: str) -> None:
    assert "has characters that do not show" in name_mistake(f"joint{bad}1")
    assert name_mistake(f"joint{bad}1").isprintable()


def test_a_name_is_as_long_as_others_may_have_to_show_it() -> None:
    assert name_mistake("x" * 64) == ""
    assert "has 65 characters" in name_mistake("x" * 65)
    assert "at most 64" in name_mistake("x" * 65)
