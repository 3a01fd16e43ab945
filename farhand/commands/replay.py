"""`farhand replay`: what was recorded, played again."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from farhand.terminal import say


def replay(
    file: Annotated[Path, typer.Argument(help="A recording; the parts that follow it count too.")],
    verify: Annotated[
        bool, typer.Option("--verify", help="Feed the recorded inputs through today's pipeline; compare the commands.")
    ] = False,
) -> None:
    """Play a recording again: with --verify through the control pipeline, as it is today.

    Exit code 0 if every command comes again, 1 if one differs.

    Example: farhand replay --verify recordings/20260102T030405Z_cell_001.mcap
    """
    from rich.console import Console
    from rich.progress import Progress

    from common.errors import ConfigError
    from farhand.exit_codes import FAILED
    from farhand.replay.recorded_cycles import cycle_count, recorded_cycles, recorded_pipeline
    from farhand.replay.verify import verify as verify_cycles

    if not verify:
        raise ConfigError("a recording can be verified only: give --verify")
    with tempfile.TemporaryDirectory() as folder, Progress(console=Console(stderr=True)) as bar:
        pipeline = recorded_pipeline(file, Path(folder))
        task = bar.add_task("verifying", total=cycle_count(file))
        verdict = verify_cycles(recorded_cycles(file), pipeline, lambda: bar.advance(task))
    say(verdict.in_words())
    if verdict.difference is not None:
        raise typer.Exit(FAILED)
