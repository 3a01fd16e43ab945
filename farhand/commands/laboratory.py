"""The laboratory, a distribution of its own that a checkout installs: its experiments, where it is installed."""

from importlib.metadata import entry_points
from typing import Any

from common.errors import NotInstalledError

GROUP, EXPERIMENTS = "farhand.lab", "experiments"
CURE = "experiments are part of Farhand's laboratory, which is not installed: run make in a checkout of Farhand"


def experiments() -> Any:
    """The laboratory's room of experiments; NotInstalledError, with what to install, without it."""
    found = [entry for entry in entry_points(group=GROUP) if entry.name == EXPERIMENTS]
    if not found:
        raise NotInstalledError(CURE)
    return found[0].load()
