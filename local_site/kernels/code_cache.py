"""Where compiled code is kept: stale once any file with compiled functions changes, as they call one another."""

import hashlib
from pathlib import Path

from numba.core.caching import InTreeCacheLocator, UserProvidedCacheLocator, UserWideCacheLocator

import local_site


def digest_of_sources(folder: Path) -> str:
    """A digest of the files below a folder that have compiled functions.

    numba looks only at a function's own file: after an update it would keep the constants and functions of others
    as they were.
    """
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        content = path.read_bytes()
        if b"@compiled" in content:
            digest.update(str(path.relative_to(folder)).encode() + b"\0" + content)
    return digest.hexdigest()


class _StaleWithAnySource:
    _stamp = digest_of_sources(Path(local_site.__file__).parent)

    def get_source_stamp(self) -> str:
        """What the compiled code must have been made from."""
        return self._stamp


class GivenFolder(_StaleWithAnySource, UserProvidedCacheLocator):
    """The folder that NUMBA_CACHE_DIR names."""


class BesideSource(_StaleWithAnySource, InTreeCacheLocator):
    """The folder beside the source."""


class UsersFolder(_StaleWithAnySource, UserWideCacheLocator):
    """The user's cache folder."""


LOCATORS = ",".join(f"{place.__module__}.{place.__qualname__}" for place in (GivenFolder, BesideSource, UsersFolder))
