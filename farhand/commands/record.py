"""`farhand record` and `farhand episode`: the recorder of this host, what is asked of it, and files made whole."""

from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from common.errors import RecordingError
from common.messages.recording import EpisodeOutcome
from common.process.log import LogFormat
from farhand.commands.options import (
    AsJson,
    CellName,
    ConfigFile,
    LinksFile,
    LocalEndpoint,
    LogLines,
    RemoteEndpoint,
    Settings,
    console_config,
    until_signal,
)
from farhand.exits import FAILED
from farhand.terminal import complain, progress_bar, say, tell, tell_done

if TYPE_CHECKING:
    from common.recording.repair import Repaired

KB, MB = 1_000, 1_000_000
record_app = typer.Typer()
episode_app = typer.Typer(
    help="Begin and end episodes of a recording, and say how they went.\n\nExample: farhand episode begin",
    no_args_is_help=True,
)

Task = Annotated[str, typer.Option(help="What is to be done, as a sentence; it stays until another is given.")]
Note = Annotated[str, typer.Option(help="A note about the episode.")]
Outcome = Annotated[EpisodeOutcome, typer.Option(help="How it went.")]


@record_app.callback(invoke_without_command=True)
def record(
    context: typer.Context,
    config: ConfigFile = None,
    settings: Settings = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the recordings; else record.folder.")] = None,
    file: Annotated[Path | None, typer.Option(help="One file instead, that does not exist yet; never split.")] = None,
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Record the site of this host whose configuration it is given, until Ctrl-C or SIGTERM.

    Its commands ask recorders that run already to begin or end, and repair files.

    Example: farhand record --config remote.toml --out recordings
    """
    if context.invoked_subcommand is not None:
        return
    from farhand.recording.site_recorder import run_recorder

    run_recorder(config, settings or (), out, file, lambda: datetime.now(UTC), until_signal(), log_format)


@record_app.command("repair")
def repair_files(
    files: Annotated[list[Path], typer.Argument(help="Recordings that were not ended in order.")],
    as_json: AsJson = False,
) -> None:
    """Make files whole whose recorder was killed, or that were cut: up to the last whole second, in place.

    What has to be cut is kept beside the file, in FILE.rest. Exit code 1 if a file cannot be repaired; the others are.

    Example: farhand record repair recordings/20260102T030405Z_cell_001.mcap
    """
    failed, results = False, []
    for file in files:
        rest = file.with_name(f"{file.name}.rest")
        try:
            done = _repair(file, rest)
        except RecordingError as error:
            complain(error)
            failed = True
            continue
        if not as_json:
            say(_in_words(file, rest, done))
        results.append({"file": file, **done._asdict(), "rest": rest if done.cut_bytes else None})
    tell((), {"repaired": results}, as_json=as_json)
    if failed:
        raise typer.Exit(FAILED)


def _in_words(file: Path, rest: Path, done: "Repaired") -> str:
    cut = f", {done.cut_bytes} bytes that were not whole are in {rest}" if done.cut_bytes else ""
    state = "whole" if done.was_whole else f"repaired{cut}"
    return f"{file} is {state}: {done.messages} messages over {done.seconds:.1f} s"


def _repair(file: Path, rest: Path) -> "Repaired":
    """Repair a file behind a bar: an hour's takes a minute."""
    from common.recording.repair import repair

    with progress_bar() as show:

        def show_bytes(done: int, size: int) -> None:
            unit, name = (MB, "MB") if size > MB else (KB, "kB")
            show(f"{file.name}, {name}", -(-done // unit), -(-size // unit))

        return repair(file, rest, show_bytes)


@record_app.command("start")
def start(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    local: LocalEndpoint = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """As the lease's holder, ask the recorders of both sites to begin, where record.start = "on_request".

    Example: farhand record start --cell cell
    """
    _ask("start", cell, at, local, config, as_json=as_json)


@record_app.command("stop")
def stop(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    local: LocalEndpoint = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Ask the recorders of both sites to end: the cell's as the lease's holder, this host's own in any case.

    Example: farhand record stop --cell cell
    """
    _ask("stop", cell, at, local, config, as_json=as_json)


@episode_app.command("begin")
def begin(
    task: Task = "",
    cell: CellName = "",
    at: RemoteEndpoint = "",
    local: LocalEndpoint = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Begin an episode; one that is under way ends.

    Example: farhand episode begin --task "put the block on the mark"
    """
    _ask("begin", cell, at, local, config, as_json=as_json, task=task)


@episode_app.command("end")
def end(
    outcome: Outcome = EpisodeOutcome.UNKNOWN,
    note: Note = "",
    cell: CellName = "",
    at: RemoteEndpoint = "",
    local: LocalEndpoint = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """End the episode under way.

    Example: farhand episode end --outcome success
    """
    _ask("end", cell, at, local, config, as_json=as_json, outcome=outcome, note=note)


@episode_app.command("label")
def label(
    outcome: Outcome = EpisodeOutcome.UNKNOWN,
    note: Note = "",
    task: Task = "",
    cell: CellName = "",
    at: RemoteEndpoint = "",
    local: LocalEndpoint = "",
    config: LinksFile = None,
    as_json: AsJson = False,
) -> None:
    """Say of the episode under way, or else of the last one, how it went.

    Example: farhand episode label --outcome failure --note "the block slipped"
    """
    _ask("label", cell, at, local, config, as_json=as_json, task=task, outcome=outcome, note=note)


def _ask(
    action: str,
    cell: str,
    at: str,
    local: str,
    config: Path | None,
    *,
    as_json: bool,
    task: str = "",
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN,
    note: str = "",
) -> None:
    from common.messages.requests import RecordAction
    from farhand.authority.record import request_record

    known = console_config(config, cell=cell, control=at, local=local)
    links, asked = known.links, (RecordAction(action), task, outcome, note)
    done = request_record(known.cell, links.control, links.local, known.name, *asked, security=links)
    tell_done(done, as_json=as_json)
