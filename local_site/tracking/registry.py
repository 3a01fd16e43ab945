"""Trackers by name: every one, also Farhand's own, is an entry point of the group `farhand.trackers`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Literal, TypeVar

import msgspec

from common.config.loading import ConfigMistake, build
from common.errors import ConfigError
from common.text import instead_of
from local_site.calibration.rig import Rig
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.tracker import Tracker

GROUP = "farhand.trackers"

S = TypeVar("S", bound=msgspec.Struct)

Option = str | int | float | bool
Scene = Literal["dark", "room", "markers", "textured"]


@dataclass(frozen=True, slots=True)
class TrackerHost:
    """The inputs to make a tracker: calibrated cameras, its options, and what is known of the operator, if anything.

    An installed tracker has the table `tracking.options`; each of Farhand's own has a table of its name, `own`.
    """

    rig: Rig
    options: Mapping[str, Option] = field(default_factory=dict)
    own: msgspec.Struct | None = None
    profile: OperatorProfile | None = None


@dataclass(frozen=True, slots=True)
class TrackerKind:
    """A tracker before it is made: how it is made, what it tracks in a few words, and what is before its cameras.

    `scene` is "dark" for a bare arm before a dark wall, "room" for one in colour in a room that is first seen without
    it, "markers" for a glove with markers, "textured" for an arm before one camera alone. So the simulated operator is
    dressed, and so a setup advises.
    """

    make: Callable[[TrackerHost], Tracker]
    tracks: str
    scene: Scene = "dark"


def tracker_kind(name: str) -> TrackerKind:
    """The tracker of that name; ConfigError, with the alternatives, without one, or if it cannot be loaded."""
    installed = _installed()
    if name not in installed:
        raise ConfigError(
            f"there is no tracker {name!r}; {instead_of(name, installed)}; or install your own first, into "
            "Farhand's environment: pip install --editable FOLDER"
        )
    point = installed[name]
    try:
        kind = point.load()
    except (Exception, SystemExit) as error:  # an installed tracker may raise anything
        raise ConfigError(
            f"the tracker {name!r} cannot be loaded from {point.value}: {type(error).__name__}: {error}"
        ) from error
    if not isinstance(kind, TrackerKind):
        raise ConfigError(f"the tracker {name!r}: {point.value} is no TrackerKind, but {type(kind).__name__}")
    return kind


def tracker_names() -> list[str]:
    """The trackers that are installed, in alphabetical order."""
    return list(_installed())


def check_options(kind: type[S], options: Mapping[str, Option]) -> S:
    """The table `tracking.options` as a msgspec struct of the tracker's own; ConfigError names every mistake."""
    mistakes: list[ConfigMistake] = []
    config = build(kind, options, ("tracking", "options"), mistakes)
    if config is None:
        raise ConfigError("\n".join(f"{'.'.join(mistake.path)}: {mistake.text}" for mistake in mistakes))
    return config


@cache
def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda point: point.name)}
