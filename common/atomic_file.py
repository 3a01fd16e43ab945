"""Atomic writes: a file takes its name only once it is complete."""

import os
from pathlib import Path

OWNER_ONLY = 0o600  # of a file that holds a secret


def write_atomically(path: Path, content: bytes, mode: int | None = None) -> None:
    """Write a file; OSError if that fails, with an earlier file kept and nothing left behind.

    With a `mode`, the file has these permissions before it has any content.
    """
    part = path.with_name(f"{path.name}.part")
    try:
        part.unlink(missing_ok=True)
        descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666 if mode is None else mode)
        with os.fdopen(descriptor, "wb") as file:
            if mode is not None:
                os.fchmod(descriptor, mode)
            file.write(content)
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
