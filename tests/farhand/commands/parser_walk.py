"""Every command and group of the command line, as its parser knows them."""

from collections.abc import Iterator
from typing import Any

import typer

from farhand.cli import app


def walk(command: Any = None, words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Each command and group with the words after `farhand`; the first is `farhand` itself."""
    command = command or typer.main.get_command(app)
    yield words, command
    for name, own in getattr(command, "commands", {}).items():
        yield from walk(own, (*words, name))


def options_of(command: Any) -> set[str]:
    """All names of a command's options."""
    return {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)}
