"""`farhand status` over a real link: live until it is asked to stop, once where nobody watches, bounded in silence."""

import io
import re
from collections.abc import Iterator

import pytest
from rich.console import Console

from common.errors import InterruptionError, TransportError
from common.link.config import ON_THIS_HOST
from common.messages.robot import RobotState
from common.process.service import StopFlag
from farhand.status import watch
from farhand.status.observed import Observed
from farhand.status.watch import NARROW, show_status
from farhand.status.words import Row, rows_of
from local_site.console.config import ConsoleConfig, ConsoleLinksConfig
from tests.common.link.secured_cell import CELL, Cell, free_port, running


@pytest.fixture(scope="module")
def cell() -> Iterator[Cell]:
    with running(ON_THIS_HOST, "tcp", operators=()) as cell:
        yield cell


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine may take its time."""
    monkeypatch.setattr(watch, "PATIENCE_S", 60.0)


def config_of(endpoint: str) -> ConsoleConfig:
    return ConsoleConfig(cell=CELL, links=ConsoleLinksConfig(control=endpoint, video=endpoint))


def shown(cell: Cell, should_stop: StopFlag, *, terminal: bool, once: bool = False, pictures: bool = True) -> str:
    file = io.StringIO()
    console = Console(file=file, force_terminal=terminal, width=200, height=60)
    show_status(config_of(cell.endpoint), should_stop, console, once=once, pictures=pictures)
    return file.getvalue()


def test_a_terminal_is_redrawn_until_it_is_asked_to_stop(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    should_stop, drawn = StopFlag(), []

    def rows(seen: Observed, state: RobotState, now_ns: int, software: str) -> list[Row]:
        drawn.append(now_ns)
        if len(drawn) == 3:
            should_stop.set()
        return rows_of(seen, state, now_ns, software)

    monkeypatch.setattr(watch, "rows_of", rows)
    told = shown(cell, should_stop, terminal=True)
    assert len(drawn) == 3
    assert "Ctrl-C ends this" in told
    assert told.count("engaged: following the hand") > 1
    assert NARROW in told, "the golden state tells of a narrow link"


def test_a_terminal_gets_the_table_once_where_that_is_asked(cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "OVER_NS", 1)
    told = shown(cell, StopFlag(), terminal=True, once=True)
    assert told.count("engaged: following the hand") == 1
    assert "Ctrl-C" not in told


def test_what_is_no_terminal_gets_a_line_for_each_row_once(
    cell: Cell, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(watch, "OVER_NS", 1)
    assert shown(cell, StopFlag(), terminal=False) == ""
    lines = capsys.readouterr().out.splitlines()
    assert "state: engaged: following the hand" in lines
    assert all(re.match(r"[A-Za-z' ]+: ", line) for line in lines)


def test_where_nothing_is_heard_it_ends_with_what_to_check(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "PATIENCE_S", 0.0)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with pytest.raises(
        TransportError, match=f"no site of cell {CELL} answers at {endpoint}: check that 'farhand remote'"
    ):
        show_status(config_of(endpoint), StopFlag(), Console(file=io.StringIO()), once=True, pictures=True)


def test_an_interruption_before_anything_was_heard_is_told_as_such() -> None:
    endpoint, should_stop = f"tcp/127.0.0.1:{free_port()}", StopFlag()
    should_stop.set()
    with pytest.raises(InterruptionError):
        show_status(config_of(endpoint), should_stop, Console(file=io.StringIO()), once=False, pictures=True)
