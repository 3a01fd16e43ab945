"""What a command says at a terminal: words of another site, of a driver or of an operator do nothing to it."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from common.errors import FarhandError, TransportError
from common.text import escaped

ShowProgress = Callable[[str, int, int | None], None]  # what is being done, how much of it, of how much (if known)


def say(sentence: str) -> None:
    """Print a sentence as one line to standard output."""
    typer.echo(escaped(sentence))


def complain(error: FarhandError) -> None:
    """Print why a command ends to standard error; what another site says is one line, a list of mistakes is not."""
    words = str(error)
    lines = [words] if isinstance(error, TransportError) else words.split("\n")
    print("\n".join(map(escaped, [f"farhand: {lines[0]}", *lines[1:]])), file=sys.stderr)  # noqa: T201  # the command line's own voice


@contextmanager
def progress_bar() -> Iterator[ShowProgress]:
    """A bar on standard error for work that takes long; a new name of the work begins a new bar."""
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bars, tasks = Progress(*columns, console=Console(stderr=True)), {}

    def show(what: str, done: int, total: int | None) -> None:
        if what not in tasks:
            bars.start()
            tasks[what] = bars.add_task(escaped(what), total=None)
        bars.update(tasks[what], completed=done, total=total)

    try:
        yield show
    finally:
        if tasks:  # else there is nothing to end, not even a line
            bars.stop()
