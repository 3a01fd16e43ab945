"""Where in a file of TOML a mistake stands: the line of each key, and which key a sentence is about; pure."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

KeyPath = tuple[str, ...]

TABLE_LINE = re.compile(r"\s*(\[\[?)([^\[\]]+)\]")
KEY = re.compile(r"[a-z]\w*(?:\.[\w-]+)*")


def key_lines(text: str, tables: Mapping[str, Any]) -> dict[KeyPath, int]:
    """The line of every key and table of a file, whose tables these are; a row of a list has its number, from 1."""
    lines: dict[KeyPath, int] = {}
    table: KeyPath = ()
    rows: Counter[KeyPath] = Counter()
    for number, line in enumerate(text.splitlines(), start=1):
        if (match := TABLE_LINE.match(line)) and is_given(tables, _split(match[2])):  # else it is a list's own line
            table = _split(match[2])
            lines.setdefault(table, number)
            if match[1] == "[[":
                rows[table] += 1
                table = (*table, str(rows[table]))
                lines[table] = number
        elif "=" in line and is_given(tables, key := (*table, *_split(line.partition("=")[0]))):
            lines.setdefault(key, number)
    for key, number in list(lines.items()):  # of a table without a line of its own, that of its first key
        for length in range(1, len(key)):
            lines.setdefault(key[:length], number)
    return lines


def is_given(value: Any, key: Sequence[str]) -> bool:
    """Return whether tables have this key; that of a row where the next part is no number is one of any row."""
    if not key:
        return True
    first, *rest = key
    if isinstance(value, list):
        own = value[int(first) - 1 : int(first)] if first.isdigit() else value
        return any(is_given(each, rest if first.isdigit() else key) for each in own)
    return isinstance(value, dict) and first in value and is_given(value[first], rest)


def key_told(sentence: str, tables: Mapping[str, Any]) -> KeyPath:
    """The key of these tables that a sentence is about: the first that it names; () where it names none.

    One with its table goes before a name that may be a word, one that is given before one that only its table is.
    """
    named = [tuple(name.split(".")) for name in KEY.findall(sentence)]
    dotted = [key for key in named if len(key) > 1]
    given = [key for key in dotted if is_given(tables, key)] or [key for key in dotted if key[0] in tables]
    return next(iter(given or [key for key in named if is_given(tables, key)]), ())


def _split(dotted: str) -> KeyPath:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))
