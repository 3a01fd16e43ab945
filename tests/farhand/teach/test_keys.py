"""Keys at the terminal, and who may run a task."""

import os
import pty
import sys
import termios

from farhand.teach.task_run import TerminalKeys, terminal_keys
from local_site.programmed.path_progress import RunOrder


def test_keys_come_without_enter_and_the_terminal_is_left_as_it_was(monkeypatch):
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "r") as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        before = termios.tcgetattr(terminal)
        with terminal_keys() as keys:
            assert keys.orders() == []
            os.write(ours, b"nxb+-p")
            assert keys.orders() == [
                RunOrder.NEXT,
                RunOrder.BACK,
                RunOrder.FASTER,
                RunOrder.SLOWER,
                RunOrder.PAUSE,
            ]
            assert keys.orders() == []
        assert termios.tcgetattr(terminal) == before
        os.close(ours)


def test_without_a_terminal_nothing_is_ordered(monkeypatch):
    assert TerminalKeys(None).orders() == []
    with open(os.devnull) as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        with terminal_keys() as keys:
            assert keys.orders() == []
