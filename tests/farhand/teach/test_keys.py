"""Keys at the terminal, and who may run a task."""

import os
import pty
import sys
import termios

import pytest
from msgspec.structs import replace

from common.errors import RefusedError
from farhand.replay.recorded_scene import recorded_cell
from farhand.teach.keys import TerminalKeys, terminal_keys
from farhand.teach.run import check_robot
from local_site.programmed.path_progress import RunOrder
from tests.farhand.replay.recorded_states import recorded_states
from tests.farhand.teach.test_task_file import TASK


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


def test_another_robot_is_refused(tmp_path):
    cell = recorded_cell(recorded_states(tmp_path).file, tmp_path)
    check_robot(TASK, cell)
    with pytest.raises(RefusedError, match="teach it there anew"):
        check_robot(TASK, replace(cell, robot="ur5"))
