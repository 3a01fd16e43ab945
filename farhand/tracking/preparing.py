"""Compiles the tracker before a command needs it, with a message for the person who waits."""

from rich.console import Console

from local_site.runtime.warm_up import warm_up
from local_site.tracking.choice import TrackingConfig


def prepare_tracker(tracking: TrackingConfig) -> None:
    """Compile the tracker, or load the code compiled earlier."""
    with Console(stderr=True).status("preparing the tracker (up to a minute the first time)"):
        warm_up(tracking)
