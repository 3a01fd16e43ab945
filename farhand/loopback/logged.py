"""What happened in a run, as rows of a table: changes of the session, and what the sites have logged; pure."""

import re
from collections.abc import Iterable

LOG_LINE = re.compile(r"(?P<site>[\w-]+): (?P<fields>level=.*)")
FIELD = re.compile(r'(\w+)=("(?:[^"\\]|\\.)*"|\S*)')
USUAL = "level", "time", "site", "event", "reason", "code"
OF_ARM = re.compile(r"-?\d+\.\d s: ")  # since the first engagement


def rows_of(events: Iterable[str]) -> list[tuple[str, str, str]]:
    """Who, how grave, and what, once for what several sites have logged in the same words."""
    who: dict[tuple[str, str], list[str]] = {}
    for event in events:
        site, level, what = _row(event)
        sites = who.setdefault((level, what), [])
        if site not in sites:
            sites.append(site)
    return [(", ".join(sites), level, what) for (level, what), sites in who.items()]


def _row(event: str) -> tuple[str, str, str]:
    logged = LOG_LINE.fullmatch(event)
    if logged is None:
        site, separator, words = event.partition(": ")
        if separator and site.isidentifier():
            return site, "", words
        return "arm" if OF_ARM.match(event) else "", "", event
    fields = {name: _value(text) for name, text in FIELD.findall(logged["fields"])}
    what = fields.get("event", "")
    others = ", ".join(f"{name} {value}" for name, value in fields.items() if name not in USUAL)
    why = fields.get("reason") or others
    return logged["site"], fields.get("level", ""), f"{what}: {why}" if why else what


def _value(text: str) -> str:
    """A value without the quotes that it is written in."""
    return re.sub(r"\\(.)", r"\1", text[1:-1]) if text.startswith('"') else text
