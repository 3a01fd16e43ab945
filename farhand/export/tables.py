"""Recorded sessions as tables: CSV, a row an instant, with units in the head."""

import csv
import io
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from common.clock import NS_PER_S
from farhand.export.output_files import ShouldStop, go_on, written_each
from farhand.export.resampling import SessionRows, blocks, check_length, instants, rows_at
from farhand.export.session import RecordedSession, SessionFacts, SessionSignals, Times, episode_at

CALCULATED = ("=", "+", "-", "@", "\t", "\r", "\n")  # what a spreadsheet takes for the beginning of a formula
TOOL_HEAD = ("tool.x [m]", "tool.y [m]", "tool.z [m]", "tool.qx [1]", "tool.qy [1]", "tool.qz [1]", "tool.qw [1]")
TIMES_HEAD = (
    "joints measured [ns UTC]",
    "sent [ns UTC]",
    "hand exposed [ns UTC]",
    "hand exposed [ns operator's clock]",
)
SUFFIX = ".csv"


def head(facts: SessionFacts) -> list[str]:
    """The names of the columns, with their units."""
    joints = facts.joint_names
    measured = [f"{name} measured [rad]" for name in joints]
    sent = [f"{name} sent [rad]" for name in joints]
    gripper = ["gripper measured [m]", "gripper sent [m]"] * facts.has_gripper
    about = ["t [s]", "t [ns UTC]", "session", "episode", "task"]
    return [as_text(name) for name in (*about, *measured, *sent, *gripper, *TOOL_HEAD, *TIMES_HEAD)]


def lines(facts: SessionFacts, signals: SessionSignals, at: Times) -> Iterator[str]:
    """The head, and a line for each instant; what is not known yet is empty."""
    yield _line(head(facts))
    for block in blocks(at):
        rows, states = rows_at(signals, block), signals.states.at(block)
        for k, instant in enumerate(block.tolist()):
            about = _about(facts, instant, states[k])
            yield _line([*about, *_figures(rows, k), *_times(rows, k, facts.utc_minus_clock_ns)])


def _about(facts: SessionFacts, instant_ns: int, state: str) -> list[object]:
    episode = episode_at(facts, instant_ns)
    since = f"{(instant_ns - facts.begin_ns) / NS_PER_S:.6f}"
    about: list[object] = [since, instant_ns + facts.utc_minus_clock_ns, state]
    return about + ([episode.number, as_text(episode.task)] if episode else ["", ""])


def as_text(words: str) -> str:
    """Words that a spreadsheet shows and does not calculate, whatever they begin with."""
    return f"'{words}" if words.startswith(CALCULATED) else words


def _figures(rows: SessionRows, k: int) -> list[str]:
    gripper = [] if rows.opening is None else [rows.opening[k], rows.sent_opening[k]]
    figures = np.concatenate((rows.q[k], rows.sent_q[k], gripper, rows.tool[k]))
    return ["" if np.isnan(figure) else f"{figure:.9g}" for figure in figures.tolist()]


def _times(rows: SessionRows, k: int, utc_minus_clock_ns: int) -> list[int | str]:
    by_host = [int(times[k]) for times in (rows.q_ns, rows.sent_ns, rows.hand_ns)]
    utc = [t_ns + utc_minus_clock_ns if t_ns else "" for t_ns in by_host]
    return [*utc, int(rows.hand_operator_ns[k]) or ""]


def _line(cells: Sequence[object]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


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
