"""`farhand experiment`."""

from pathlib import Path
from typing import Annotated

import typer

from farhand.commands.options import until_signal


def experiment(
    name: Annotated[
        str, typer.Argument(help="follow: hand against tool; hazel: one camera's arm; drift: its command.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for report, plots and data; other files in it stay.")],
    quick: Annotated[bool, typer.Option("--quick", help="A short motion, to see that it works.")] = False,
) -> None:
    """Run an experiment on the simulated operator and write report.html, report.json, plots (PNG) and data (CSV).

    Example: farhand experiment follow --out build/follow
    """
    from farhand.experiments.run import run_experiment

    typer.echo(run_experiment(name, out, quick, until_signal()))
