"""The help of every command and group: by -h too, in groups, with an example that the parser takes."""

import shlex
from typing import Any

import pytest
import typer
from typer.testing import CliRunner

from farhand.cli import app
from tests.farhand.commands.parser_walk import walk

EVERY = [pytest.param(words, command, id=" ".join(words) or "farhand") for words, command in walk()]
ROOT: Any = typer.main.get_command(app)
GROUPS = ["Start", "Operate", "Record", "Set up", "Maintain"]


@pytest.mark.parametrize(("words", "command"), EVERY)
def test_the_help_has_an_example_of_its_own_command(words: tuple[str, ...], command: Any) -> None:
    done = CliRunner().invoke(app, [*words, "-h"])
    assert done.exit_code == 0
    assert done.output == CliRunner().invoke(app, [*words, "--help"]).output
    assert "Usage" in done.output
    examples = [line.strip() for line in command.help.splitlines() if line.strip().startswith("Example: ")]
    assert examples
    for example in examples:
        assert f" {example}" in " ".join(done.output.split())
        assert_taken(example.removeprefix("Example: "), words)


def assert_taken(line: str, words: tuple[str, ...]) -> None:
    """The parser takes the line, which is one of the command or of one in its group."""
    program, *rest = shlex.split(line.partition(" > ")[0])  # what follows is the shell's
    assert program == "farhand"
    assert tuple(rest[: len(words)]) == words
    command = ROOT
    while rest and rest[0] in getattr(command, "commands", {}):
        command = command.commands[rest.pop(0)]
    command.make_context("farhand", rest)


def test_commands_are_listed_in_groups() -> None:
    panels = [getattr(command, "rich_help_panel", None) for command in ROOT.commands.values()]
    assert set(panels) == set(GROUPS)
    output = CliRunner().invoke(app, ["-h"]).output
    headings = [line.strip("╭─╮ ") for line in output.splitlines() if line.startswith("╭")]
    assert headings == ["Options", *GROUPS]


def test_an_example_that_the_parser_refuses_is_noticed() -> None:
    with pytest.raises(Exception, match="No such option: --none"):
        assert_taken("farhand lease show --none", ("lease",))
