"""`farhand export csv`: a table of each session."""

from collections.abc import Sequence
from pathlib import Path

from farhand.export.output_files import ShouldStop, go_on, written_each
from farhand.export.resampling import check_length, instants
from farhand.export.session import RecordedSession
from farhand.export.tables.table import lines

SUFFIX = ".csv"


def export_csv(sessions: Sequence[RecordedSession], out: Path, fps: int, should_stop: ShouldStop) -> list[Path]:
    """Write a table of each session; ConfigError if one of them exists, ExportError if one would be too long."""
    for session in sessions:
        facts = session.facts
        check_length(facts, facts.end_ns - facts.begin_ns, fps)

    def write(session: RecordedSession, path: Path) -> None:
        facts = session.facts
        at = instants(facts.begin_ns, facts.end_ns, fps)
        with path.open("w", encoding="utf-8", newline="") as file:
            for line in lines(facts, session.signals(), at):
                go_on(should_stop)
                file.write(line)

    return written_each(sessions, out, SUFFIX, write)
