"""Refuses one camera or recording that is given for two: two views from one place show no depth."""

import filecmp
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path

from common.cameras.camera import Source
from common.cameras.images import IMAGE_SUFFIXES
from common.cameras.modes import device_of
from common.cameras.shown_source import shown_source
from common.errors import ConfigError


def refuse_same(sources: Mapping[str, Source]) -> None:
    """ConfigError if two of the sources, by the names of their cameras, are one, by path, link or content."""
    for (first, one), (second, other) in combinations(sources.items(), 2):
        if why := _likeness(str(one), str(other)):
            both = f"{shown_source(one)} and {shown_source(other)}"
            raise ConfigError(f"cameras {first} and {second}: {both} {why}; give each camera a source of its own")


def _likeness(one: str, other: str) -> str:
    """Say what two sources have in common if they are one; empty if they are not."""
    a, b = (Path(device_of(source) or source) for source in (one, other))
    if one == other or a.resolve() == b.resolve():
        return "are the same"
    if (a.is_file() and b.is_file() and _same_bytes(a, b)) or (a.is_dir() and b.is_dir() and _same_images(a, b)):
        return "have the same content"
    return ""


def _same_bytes(one: Path, other: Path) -> bool:
    return filecmp.cmp(one, other, shallow=False)


def _same_images(one: Path, other: Path) -> bool:
    a, b = (
        sorted(path for path in folder.iterdir() if path.suffix.lower() in IMAGE_SUFFIXES) for folder in (one, other)
    )
    return bool(a) and len(a) == len(b) and all(map(_same_bytes, a, b))
