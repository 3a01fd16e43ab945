"""Output of commands at a terminal: words of another site, of a driver or of an operator do nothing to it."""

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import msgspec
import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from common.errors import FarhandError, TransportError
from common.text import escaped

UNLIMITED = 10_000  # columns: no cell is broken
ShowProgress = Callable[[str, int, int | None], None]  # what is being done, how much of it, of how much (if known)


def say(sentence: str) -> None:
    """Print a sentence as one line to standard output."""
    typer.echo(escaped(sentence))


def aside(*, as_json: bool) -> Callable[[str], None]:
    """Says a sentence that is no result: to standard error where the result alone is wanted, as JSON."""
    return (lambda sentence: typer.echo(escaped(sentence), err=True)) if as_json else say


def tell(words: Iterable[str], result: Mapping[str, object], *, as_json: bool) -> None:
    """Print what came of a command: in words, a line each, or as one JSON object, in ASCII."""
    if as_json:
        plain = json.loads(msgspec.json.encode(result, enc_hook=str))  # paths; what is no number becomes null
        typer.echo(json.dumps(plain, indent=2))
        return
    for line in words:
        say(line)


def tell_done(sentence: str, *, as_json: bool) -> None:
    """Print what a site replied once it has done what was asked."""
    tell([sentence], {"done": True, "reason": sentence}, as_json=as_json)


def table_of(head: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    """A table whose cells do nothing to a terminal."""
    table = Table(box=SIMPLE, collapse_padding=True)
    for name in head:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*(Text(escaped(cell)) for cell in row))
    return table


def show_table(table: Table) -> None:
    """Print a table as wide as the terminal, or a line for each row where the output is none."""
    console = Console()
    (console if console.is_terminal else Console(width=UNLIMITED)).print(table)


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
