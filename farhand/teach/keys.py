"""What the operator orders of a run at the terminal, key by key."""

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from local_site.programmed.path_progress import RunOrder

KEYS = {
    "p": RunOrder.PAUSE,
    "n": RunOrder.NEXT,
    "b": RunOrder.BACK,
    "+": RunOrder.FASTER,
    "-": RunOrder.SLOWER,
}
HELP = "keys here: p pauses and goes on, n to the next way point, b back to the last one, + faster, - slower"
MOST_BYTES = 64


class TerminalKeys:
    """The keys pressed at a terminal, by its descriptor; none without one."""

    def __init__(self, terminal: int | None) -> None:
        self._terminal = terminal

    def orders(self) -> list[RunOrder]:
        """The orders since it was asked last, without waiting for any."""
        if self._terminal is None or not select.select([self._terminal], [], [], 0.0)[0]:
            return []
        pressed = os.read(self._terminal, MOST_BYTES)
        if not pressed:
            self._terminal = None
        return [KEYS[key] for key in pressed.decode(errors="replace") if key in KEYS]


@contextmanager
def terminal_keys() -> Iterator[TerminalKeys]:
    """Keys of standard input come one by one, without Enter, as long as the block lasts; Ctrl-C stays what it is."""
    if not sys.stdin.isatty():
        yield TerminalKeys(None)
        return
    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal)
    try:
        yield TerminalKeys(terminal)
    finally:
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)
