"""Conversation of the setup with a person: questions with an answer proposed, at a terminal."""

import sys
from collections.abc import Mapping
from typing import Protocol

from common.errors import ConfigError, InterruptionError
from common.text import escaped
from farhand.terminal import say


class SetupPerson(Protocol):
    """Who sets up: `tell` a sentence, `show` a line that the next one replaces, `ask` a question."""

    def tell(self, sentence: str) -> None: ...

    def show(self, line: str) -> None: ...

    def ask(self, question: str, default: str) -> str: ...


class TerminalPerson:
    """A person at a terminal; ConfigError where there is none."""

    def __init__(self) -> None:
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            raise ConfigError(
                "farhand setup asks questions and needs a terminal: start it without a pipe, over ssh with -t; "
                "without a terminal use farhand calibrate live and farhand config show local-cameras"
            )
        self._showing = False

    def tell(self, sentence: str) -> None:
        """Print a sentence as a line of its own."""
        self._clear()
        say(sentence)

    def show(self, line: str) -> None:
        """Replace the line that was shown last."""
        sys.stdout.write(f"\r\x1b[K{escaped(line)}")
        sys.stdout.flush()
        self._showing = True

    def ask(self, question: str, default: str) -> str:
        """The answer, or the default for an empty one; InterruptionError at the end of the input."""
        self._clear()
        try:
            return input(f"{escaped(question)} [{escaped(default)}] ").strip() or default
        except EOFError as error:
            raise InterruptionError("the input ended; start farhand setup again, it keeps what is done") from error

    def _clear(self) -> None:
        if self._showing:
            sys.stdout.write("\r\x1b[K")
            self._showing = False


def choose(person: SetupPerson, question: str, options: Mapping[str, str], default: str) -> str:
    """Which of the options (what to answer, and what it means) a person chooses."""
    for key, meaning in options.items():
        person.tell(f"  {key}: {meaning}")
    while (answer := person.ask(question, default)) not in options:
        person.tell(f"answer one of {', '.join(options)}")
    return answer


def confirm(person: SetupPerson, question: str, default: bool) -> bool:
    """Ask whether a person agrees."""
    words = {"y": True, "yes": True, "n": False, "no": False}
    while (answer := person.ask(f"{question} (y/n)", "y" if default else "n").lower()) not in words:
        person.tell("answer y or n")
    return words[answer]


def ask_number(person: SetupPerson, question: str, default: float, low: float, high: float) -> float:
    """A number from low to high."""
    while True:
        try:
            number = float(person.ask(question, f"{default:g}").replace(",", "."))
        except ValueError:
            number = float("nan")
        if low <= number <= high:
            return number
        person.tell(f"answer a number from {low:g} to {high:g}")
