"""Every command of an earlier release is still taken, with all its options."""

from pathlib import Path
from typing import Any

import pytest
import typer

from farhand.cli import app
from tests.farhand.commands.parser_walk import options_of

RELEASED = Path(__file__).parents[2] / "golden/release-0.1.0/commands.txt"
COMMAND_LINES = RELEASED.read_text().splitlines()


@pytest.mark.parametrize("line", COMMAND_LINES)
def test_a_released_command_has_its_options(line: str) -> None:
    _, *words = line.split()
    names = [word for word in words if not word.startswith("--")]
    command: Any = typer.main.get_command(app)
    for name in names:
        command = command.commands[name]
    assert set(words[len(names) :]) <= options_of(command)
