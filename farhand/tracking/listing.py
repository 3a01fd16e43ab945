"""The trackers that are installed: where each comes from, what it tracks, why it cannot be used."""

from dataclasses import dataclass
from importlib.metadata import entry_points

from common.errors import ConfigError
from local_site.tracking.registry import GROUP, tracker_kind
from remote_site.drivers.listing import origin_of


@dataclass(frozen=True, slots=True)
class ListedTracker:
    """A tracker by its name: the package that provides it, what it tracks, or why it cannot be loaded."""

    name: str
    origin: str
    tracks: str
    wrong: str = ""

    def __str__(self) -> str:
        return f"{self.name} ({self.origin}): {self.tracks or f'CANNOT BE USED: {self.wrong}'}"


def installed_trackers() -> list[ListedTracker]:
    """Every tracker that an installed package provides, by name; each is loaded, and none is made."""
    listed = []
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            listed.append(ListedTracker(point.name, origin_of(point), tracker_kind(point.name).tracks))
        except ConfigError as error:
            listed.append(ListedTracker(point.name, origin_of(point), "", str(error)))
    return listed
