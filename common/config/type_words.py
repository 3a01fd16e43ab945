"""Plain words, with a cure, for what a checker of types says of a configuration's value; pure."""

import re
import tomllib
from collections.abc import Sequence
from datetime import date, time
from typing import Any

SAID = re.compile(
    r"Expected `(?P<wanted>[^`]+)`"
    r"(?: of length (?P<most>>=|<=|) ?(?P<length>\d+))?(?P<bound> [<>]=? \S+)?"
    r"(?:, got (?:`(?P<got>[^`]+)`|(?P<count>\d+)))?(?: - at `\$(?P<place>.*)`)?"
)
PLACE = re.compile(r"\[(\d+)\]")
LENGTHS = {">=": "at least ", "<=": "at most ", "": ""}
KINDS = {
    "float": "a number",
    "int": "a whole number",
    "bool": "true or false",
    "str": "words in quotes",
    "array": "a list in brackets",
    "object": "a table",
    "date": "a date",
    "datetime": "a date with a time",
    "time": "a time of day",
}


def in_plain_words(said: str, value: Any, meaning: str = "") -> str:
    """Say what to give in place of a refused value; `meaning` is what its key says of it, with the unit."""
    found = SAID.fullmatch(said)
    if found is None:
        return said
    wanted = found["wanted"].split(" | ")
    places = [str(int(number) + 1) for number in PLACE.findall(found["place"] or "")]
    if not places and isinstance(value, str) and found["got"] and _fits_without_quotes(value, wanted):
        return f"write it without quotes: {value}"
    what = " or ".join(KINDS.get(kind, kind) for kind in wanted if kind != "null") + (found["bound"] or "")
    if found["length"]:
        length = f"{LENGTHS[found['most']]}{found['length']}"
        letters = "character" if found["length"] == "1" else "characters"
        what = f"words of {length} {letters}" if wanted[0] == "str" else f"a list of {length}"
    about = f" ({meaning})" if meaning else ""
    where = f" as number {' of number '.join(reversed(places))} of the list" if places else ""
    instead = f", not of {found['count']}" if found["count"] else ""
    if found["got"]:
        instead = f", not {KINDS.get(found['got'], found['got'])}"
    return f"give {what}{where}{instead}{about}"


def as_written(value: Any) -> str:
    """A value of TOML in its own notation, words in single quotes."""
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {as_written(own)}' for key, own in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(as_written, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    return value.isoformat() if isinstance(value, date | time) else repr(value)


def _fits_without_quotes(text: str, wanted: Sequence[str]) -> bool:
    """Return whether a text in quotes would be of the wanted type without them."""
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return False
    kind = type(value).__name__
    return kind in wanted or (kind == "int" and "float" in wanted)
