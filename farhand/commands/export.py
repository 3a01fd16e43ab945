"""`farhand export`: recordings as a LeRobot dataset, as tables, as videos."""

import importlib
from pathlib import Path
from typing import Annotated

import typer

from common.errors import NotInstalledError
from farhand.commands.options import AsJson, until_signal
from farhand.terminal import progress_bar, tell

NEEDED = "av", "pyarrow"

export_app = typer.Typer(
    help="Turn recordings into data for others.\n\nExample: farhand export mp4 recordings/*.mcap --out videos",
    no_args_is_help=True,
)

Sessions = Annotated[list[Path], typer.Argument(help="Recordings; the parts of a split one are joined.")]
Folder = Annotated[Path, typer.Option(help="Folder to write into.")]
Rate = Annotated[
    int, typer.Option(help="Instants per second; of everything the newest that is not later.", min=1, max=240)
]


@export_app.command("lerobot")
def lerobot(
    sessions: Sessions,
    out: Annotated[Path, typer.Option(help="Folder of the dataset, which does not exist yet.")],
    fps: Rate = 30,
    view: Annotated[list[str] | None, typer.Option(help="A camera to take; repeatable; else all.")] = None,
    task: Annotated[str, typer.Option(help="The task of episodes for which none was given.")] = "not named",
    as_json: AsJson = False,
) -> None:
    """Write the episodes of recordings as one LeRobot dataset (v3.0); after Ctrl-C the same command goes on.

    Example: farhand export lerobot recordings/*.mcap --out dataset
    """
    _check_installed()
    from farhand.export.lerobot.dataset_export import ExportSettings, export_lerobot
    from farhand.export.recording import open_sessions

    settings = ExportSettings(out, fps, tuple(view or ()), task)
    with open_sessions(sessions) as opened, progress_bar() as show:
        done = export_lerobot(opened, settings, until_signal(), show)
    words = [f"left out: {sentence}" for sentence in done.left_out]
    words.append(f"{out}: {done.episodes} episodes, {done.frames} frames, of which {done.encoded} were encoded now")
    tell(words, {"out": out, **done._asdict()}, as_json=as_json)


@export_app.command("csv")
def csv(sessions: Sessions, out: Folder, fps: Rate = 50, as_json: AsJson = False) -> None:
    """Write a table of each recording: a row an instant, with units in the head.

    Example: farhand export csv recordings/*.mcap --out tables
    """
    from farhand.export.recording import open_sessions
    from farhand.export.tables import export_csv

    with open_sessions(sessions) as opened:
        written = export_csv(opened, out, fps, until_signal())
    tell([f"written: {', '.join(map(str, written))}"], {"written": written}, as_json=as_json)


@export_app.command("mp4")
def mp4(sessions: Sessions, out: Folder, fps: Rate = 25, as_json: AsJson = False) -> None:
    """Write a video of each recording: all views side by side, with time, state and joints below.

    Example: farhand export mp4 recordings/*.mcap --out videos
    """
    _check_installed()
    from farhand.export.recording import open_sessions
    from farhand.export.videos.write import export_mp4

    with open_sessions(sessions) as opened, progress_bar() as show:
        written = export_mp4(opened, out, fps, until_signal(), show)
    tell([f"written: {', '.join(map(str, written))}"], {"written": written}, as_json=as_json)


def _check_installed() -> None:
    """NotInstalledError, with the command for it, where the extra `export` is missing."""
    try:
        for module in NEEDED:
            importlib.import_module(module)
    except ImportError as error:
        cure = "pip install 'farhand[export]'"
        raise NotInstalledError(f"to export, PyAV and pyarrow are needed ({error}): {cure}") from error
