"""Text from elsewhere, fit for where it goes: cut, in one line, escaped for a terminal, TOML, XML or a file's name."""

import re
from collections.abc import Collection
from difflib import get_close_matches

from common.errors import ConfigError

ELLIPSIS = "…"
MOST_OF_NAME = 64  # characters
SHOWN_OF_NAME = 24  # characters of a name that is refused
NOT_IN_FILE_NAMES = re.compile(r"[^\w .+-]|^\.")


def cut(text: str, most: int) -> str:
    """The text with at most `most` characters, the last an ellipsis where some are missing; always valid UTF-8."""
    shown = text if len(text) <= most else text[: most - 1] + ELLIPSIS
    return shown.encode(errors="replace").decode()


def escaped(text: str) -> str:
    r"""The text in one line, with \x1b, \n or \u202e in the place of what a terminal obeys or does not show.

    A comment of TOML takes it as it is.
    """
    if text.isprintable():
        return text
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


def instead_of(name: str, names: Collection[str]) -> str:
    """The cure for a name that is none of these: the one that it is like, if any, and all of them."""
    near = get_close_matches(name, names, n=1)
    return f"{f'did you mean {near[0]}? Else ' if near else ''}choose one of: {', '.join(names)}"


def name_mistake(name: str) -> str:
    """Describe what bars a name that others gave, as words after its place; empty where nothing does."""
    shown = escaped(cut(name, SHOWN_OF_NAME))
    if not name.isprintable():
        return f"has characters that do not show: '{shown}'; give a name of letters, digits and underscores"
    if len(name) > MOST_OF_NAME:
        return f"has {len(name)} characters: '{shown}'; give a name of at most {MOST_OF_NAME}"
    return ""


def toml_string(words: str) -> str:
    """A TOML string in one line that reads as exactly these words; ConfigError where they are no Unicode."""
    try:
        words.encode()
    except UnicodeEncodeError as error:
        raise ConfigError(f"'{escaped(words)}' cannot stand in TOML; rename it, in UTF-8") from error
    return f'"{"".join(map(_in_toml, words))}"'


def _in_toml(char: str) -> str:
    if char in '"\\':
        return f"\\{char}"
    if char.isprintable():
        return char
    return f"\\u{ord(char):04x}" if ord(char) <= 0xFFFF else f"\\U{ord(char):08x}"


def in_xml_comment(words: str) -> str:
    """The words in one line, as they may stand in a comment of XML."""
    return re.sub("-(?=-)", "- ", escaped(words))


def file_name(words: str) -> str:
    """The words as a file's name, which stays in its folder whatever they are, and is not hidden there."""
    return NOT_IN_FILE_NAMES.sub("_", words) or "_"
