"""A file that takes its place only once it is whole."""

from pathlib import Path


def write_whole(path: Path, content: bytes) -> None:
    """Write a file; OSError, with an earlier one kept and nothing left behind, if that fails."""
    part = path.with_name(f"{path.name}.part")
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError:
        part.unlink(missing_ok=True)
        raise
