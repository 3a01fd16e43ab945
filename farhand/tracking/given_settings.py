"""Check of the settings given to a track: no other tracker than an option names, and what is not used."""

from collections.abc import Iterator, Sequence
from typing import Any

from common.config.loading import apply_setting, load_config
from common.errors import ConfigError
from local_site.config import LocalConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.registry import tracker_names


def refuse_other_tracker(tracker: str, settings: Sequence[str]) -> None:
    """ConfigError if the settings name a tracker that there is not, or another than --tracker or --monocular does."""
    method = _given_tracking(settings).get("method", tracker)
    if method == tracker:
        return
    load_config(LocalConfig, None, [f"tracking.method={method}"])
    raise ConfigError(
        f"--set tracking.method={method}: an option asks for the tracker {tracker}; leave one of them out"
    )


def unused_settings(tracking: TrackingConfig, settings: Sequence[str]) -> Iterator[str]:
    """A sentence for each setting that a track does not use, though a person may expect it to.

    Of tables of other trackers only `settings`, those of the command line, count: a file may hold the tables of all.
    """
    if tracking.profile_dir:
        yield "tracking.profile_dir is not used here: a track learns hand and forearm anew, and keeps no profile"
    used, given = tracking.method, _given_tracking(settings)
    for other in tracker_names():
        for key in given.get(other, {}) if other != used else ():
            cure = f"give tracking.{used}.{key}" if hasattr(getattr(tracking, used, None), key) else "leave it out"
            yield f"tracking.{other}.{key} belongs to the tracker {other}, but {used} is in use: {cure}"


def _given_tracking(settings: Sequence[str]) -> dict[str, Any]:
    """The table `tracking` of settings, unchecked."""
    table: dict[str, Any] = {}
    for setting in settings:
        apply_setting(table, setting)
    tracking = table.get("tracking", {})
    return tracking if isinstance(tracking, dict) else {}
