"""Origin of a track: what it was made of and with, as the rows of its report's first table."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

import msgspec

from local_site.config import LocalConfig

Rows = Sequence[tuple[str, str]]
"""The subject of a row, and what it says."""


def origin_rows(
    rig: Path, sources: Sequence[tuple[str, str]], site: LocalConfig, fps: float | None, version: str, now: datetime
) -> Rows:
    """The rows: recordings by the names of their cameras, rig, rate (Hz), tracker, settings, version, date (UTC)."""
    settings = ", ".join(_settings(site)) or "the defaults"
    return [
        *((f"camera {name}", source) for name, source in sources),
        ("rig", str(rig)),
        ("pictures a second", "as the cameras gave them" if fps is None else f"{fps:g}"),
        ("tracker", site.tracking.method),
        ("settings", settings),
        ("Farhand", version),
        ("tracked on", f"{now:%Y-%m-%d %H:%M} UTC"),
    ]


def _settings(site: LocalConfig) -> Iterator[str]:
    """List what a track uses of the configuration and is not as by default; the tracker has a row of its own."""
    usual, tracker = LocalConfig(), site.tracking.method
    yield from _changes(f"tracking.{tracker}", getattr(site.tracking, tracker), getattr(usual.tracking, tracker))
    yield from _changes("drift", site.drift, usual.drift)
    yield from _changes("gesture", site.gesture, usual.gesture)


def _changes(table: str, given: msgspec.Struct, usual: msgspec.Struct) -> Iterator[str]:
    for name in given.__struct_fields__:
        value, default, key = getattr(given, name), getattr(usual, name), f"{table}.{name}"
        if isinstance(value, msgspec.Struct):
            yield from _changes(key, value, default)
        elif value != default:
            yield f"{key} = {msgspec.json.encode(value).decode()}"
