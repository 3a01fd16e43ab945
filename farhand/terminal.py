"""What a command says at a terminal: words of another site, of a driver or of an operator do nothing to it."""

import sys

import typer

from common.errors import FarhandError, TransportError
from common.text import escaped


def say(sentence: str) -> None:
    """Print a sentence as one line to standard output."""
    typer.echo(escaped(sentence))


def complain(error: FarhandError) -> None:
    """Print why a command ends to standard error; what another site says is one line, a list of mistakes is not."""
    words = str(error)
    lines = [words] if isinstance(error, TransportError) else words.split("\n")
    print("\n".join(map(escaped, [f"farhand: {lines[0]}", *lines[1:]])), file=sys.stderr)  # noqa: T201  # the command line's own voice
