"""The operators' profiles on disk, a file for each name; tracking works without them."""

from collections.abc import Callable
from pathlib import Path

import msgspec

from common.atomic_file import write_atomically
from common.clock import NS_PER_S
from common.errors import ConfigError
from local_site.tracking.silhouette.operator_profile import OperatorProfile, profile_mistakes

SAVE_EVERY_NS = 60 * NS_PER_S
CURE = "delete it, and it is learned again"

Learned = Callable[[], OperatorProfile | None]
"""Asks a tracker for what it has learned of the operator so far."""


def load_profile(path: Path) -> OperatorProfile | None:
    """Read a profile, None where there is none yet; ConfigError names what is wrong and the cure."""
    try:
        profile = msgspec.json.decode(path.read_bytes(), type=OperatorProfile)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise ConfigError(f"cannot read the profile {path}: {error.strerror}; choose another profile_dir") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path} is not a profile of this version, or not whole: {error}; {CURE}") from error
    mistakes = profile_mistakes(profile)
    if mistakes:
        raise ConfigError(f"the profile {path} cannot be used: {'; '.join(mistakes)}; {CURE}")
    return profile


def save_profile(profile: OperatorProfile, path: Path) -> None:
    """Write a readable profile; an earlier one is replaced only by a complete one. ConfigError if it fails."""
    text = msgspec.json.format(msgspec.json.encode(profile), indent=2) + b"\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, text)
    except OSError as error:
        raise ConfigError(f"cannot write the profile {path}: {error.strerror}; choose another profile_dir") from error


class ProfileStore:
    """Keeps the profile of one operator in a folder, or nothing where no folder is given.

    If a file is wrong, `warn` is called once with the reason; it stays unchanged, and the run continues without.
    """

    def __init__(self, folder: str, operator: str, warn: Callable[[str], None]) -> None:
        self._path = Path(folder).expanduser() / f"{operator}.json" if folder else None
        self._warn = warn
        self._saved_ns: int | None = None
        self.known: OperatorProfile | None = None
        if self._path is not None:
            try:
                self.known = load_profile(self._path)
            except ConfigError as error:
                self._give_up(error)

    def keep(self, learned: Learned, now_ns: int) -> None:
        """Save what is learned, once a minute."""
        if self._saved_ns is None:
            self._saved_ns = now_ns
        elif now_ns - self._saved_ns >= SAVE_EVERY_NS:
            self._saved_ns = now_ns
            self.save(learned)

    def save(self, learned: Learned) -> None:
        """Save what is learned, if anything is."""
        profile = learned() if self._path is not None else None
        if self._path is not None and profile is not None:
            try:
                save_profile(profile, self._path)
            except ConfigError as error:
                self._give_up(error)

    def _give_up(self, error: ConfigError) -> None:
        self._path = None
        self._warn(str(error))
