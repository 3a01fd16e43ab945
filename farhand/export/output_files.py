"""A file for each session: it takes its name once it is whole, and never that of one that exists."""

from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from common.errors import ConfigError, ExportError, InterruptionError
from farhand.export.session import RecordedSession
from farhand.outputs import make_folder

ShouldStop = Callable[[], bool]


def written_each(
    sessions: Sequence[RecordedSession], out: Path, suffix: str, write: Callable[[RecordedSession, Path], None]
) -> list[Path]:
    """Write a file for each session, which takes its name once it is whole; those that are there already stay."""
    make_folder("--out", out)
    paths = [out / f"{session.facts.name}{suffix}" for session in sessions]
    if existing := [str(path) for path in paths if path.exists()]:
        raise ConfigError(f"never written over: {', '.join(existing)}; give another --out, or remove it first")
    if len(set(paths)) < len(paths):
        raise ExportError("two sessions have the same name; export them into folders of their own")
    for session, path in zip(sessions, paths, strict=True):
        with TemporaryDirectory(dir=out, prefix=".export-") as private:
            part = Path(private) / path.name
            write(session, part)
            part.replace(path)
    return paths


def go_on(should_stop: ShouldStop) -> None:
    """InterruptionError once the work should stop."""
    if should_stop():
        raise InterruptionError("interrupted; the files that are whole are kept")
