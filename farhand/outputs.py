"""Files and folders of results: writable, and never over their inputs."""

import glob
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import TextIO

from common.atomic_file import write_atomically
from common.cameras.images import IMAGE_SUFFIXES
from common.errors import ConfigError


def check_file(option: str, out: Path, inputs: Iterable[str | Path] = ()) -> None:
    """ConfigError, before any work, if a file cannot be written there or is one that is read."""
    if out.is_dir() or not out.parent.is_dir():
        raise ConfigError(f"{option} {out}: give a file in a folder that exists")
    is_device = out.exists() and not out.is_file()
    if not (os.access(out, os.W_OK) if is_device else _takes_files(out.resolve().parent)):
        raise ConfigError(f"{option} {out} cannot be written; choose another file")
    _refuse_inputs(option, out, inputs)


def check_new_file(option: str, out: Path, inputs: Iterable[str | Path] = ()) -> None:
    """As `check_file`, and ConfigError if there is a file of that name already: hours of work are not replaced."""
    check_file(option, out, inputs)
    if out.is_file():
        raise ConfigError(f"{option} {out} exists already; give another name, or move it away first")


def check_folder(option: str, folder: Path | None, inputs: Iterable[str | Path] = ()) -> None:
    """ConfigError, before any work, if a folder of results cannot be made there or is one that is read."""
    if folder is None:
        return
    existing = next(path for path in (folder, *folder.absolute().parents) if os.access(path, os.F_OK))
    if not existing.is_dir():
        raise ConfigError(f"{option} {existing} is a file; give a folder")
    if not _takes_files(existing):
        raise ConfigError(f"{option} {folder} cannot be written; choose another folder")
    _refuse_inputs(option, folder, [_folder_of_pictures(Path(given)) for given in inputs])


def _takes_files(folder: Path) -> bool:
    """Try whether a file can be made in a folder: permissions alone say nothing of a file system such as /proc."""
    try:
        with TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _folder_of_pictures(given: Path) -> Path:
    """The folder that a pattern or a picture names; anything else as it is."""
    is_inside = glob.has_magic(given.name) or given.suffix.lower() in IMAGE_SUFFIXES
    return given.parent if is_inside else given


def _refuse_inputs(option: str, out: Path, inputs: Iterable[str | Path]) -> None:
    for given in map(Path, inputs):
        if out.exists() and given.exists() and out.samefile(given):
            raise ConfigError(f"{option} {out} would overwrite what is read; choose another name")


def refuse_shared(outputs: Mapping[str, Path | None]) -> None:
    """ConfigError if two options, by their names, would write to the same place."""
    seen: dict[Path, str] = {}
    for option, out in outputs.items():
        if out is not None and (other := seen.setdefault(out.resolve(), option)) != option:
            raise ConfigError(f"{other} and {option} are both {out}; give each a name of its own")


def make_folder(option: str, folder: Path) -> None:
    """Create a folder of results if it is missing; ConfigError, before any work, if it cannot be made or written."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigError(f"{option} {folder} cannot be made: {error.strerror}; choose another folder") from error
    if not _takes_files(folder):
        raise ConfigError(f"{option} {folder} cannot be written; choose another folder")


def write_result(path: Path, content: bytes, mode: int | None = None) -> None:
    """Write a file of results whole; ConfigError, with the earlier one kept, if that fails.

    With a `mode`, the file has these permissions before it has any content.
    """
    try:
        write_atomically(path, content, mode)
    except OSError as error:
        raise ConfigError(f"cannot write {path}: {error.strerror}; choose a folder that can be written") from error


@contextmanager
def written_at_end(out: Path) -> Iterator[TextIO]:
    """A text file that replaces an earlier one once it has a line, so that a failure leaves the earlier file alone."""
    if out.exists() and not out.is_file():
        with out.open("w", encoding="utf-8") as lines:
            yield lines
        return
    out = out.resolve()
    part = out.with_name(f"{out.name}.part")
    try:
        with part.open("w", encoding="utf-8", buffering=1) as lines:
            yield lines
    finally:
        text = part.read_bytes() if part.exists() else b""
        whole = text.rfind(b"\n") + 1
        if whole < len(text):
            os.truncate(part, whole)  # an incomplete last line, as of a full disk
        if whole:
            part.replace(out)
        else:
            part.unlink(missing_ok=True)
