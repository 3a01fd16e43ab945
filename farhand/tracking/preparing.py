"""Prepares the tracker before a command needs it, and says so where a person waits."""

from rich.console import Console

from local_site.runtime.warm_up import warm_up
from local_site.tracking.choice import TrackingConfig


def prepare_tracker(tracking: TrackingConfig) -> None:
    """Have the tracker compiled, or load what was compiled before."""
    with Console(stderr=True).status("preparing the tracker (up to a minute the first time)"):
        warm_up(tracking)
