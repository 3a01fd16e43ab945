"""Cache of compiled code: stale once any file with compiled functions changes, as they call one another."""

import hashlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

from numba.core.caching import FunctionCache, InTreeCacheLocator, UserProvidedCacheLocator, UserWideCacheLocator

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
        """Return the stamp of all that the compiled code must have been made from."""
        return self._stamp


class GivenFolder(_StaleWithAnySource, UserProvidedCacheLocator):
    """The folder that NUMBA_CACHE_DIR names."""


class BesideSource(_StaleWithAnySource, InTreeCacheLocator):
    """The folder beside the source."""


class UsersFolder(_StaleWithAnySource, UserWideCacheLocator):
    """The user's cache folder."""


LOCATORS = ",".join(f"{place.__module__}.{place.__qualname__}" for place in (GivenFolder, BesideSource, UsersFolder))


class CodeCache(FunctionCache):
    """The code of one function on disk; where it cannot be read or kept, as on a full disk, it is used all the same.

    That is a warning, once for each folder.
    """

    _said: ClassVar[set[str]] = set()

    @contextmanager
    def _guard_against_spurious_io_errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            if self.cache_path not in self._said:
                self._said.add(self.cache_path)
                why = f"in {self.cache_path}: {error.strerror or error}"
                warnings.warn(
                    f"compiled code cannot be kept {why}; each start compiles it", RuntimeWarning, stacklevel=2
                )
