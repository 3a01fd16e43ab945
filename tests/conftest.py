"""What concerns every test: their order when two run at once, no deadlines, signal handlers that end with the test."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from common.service import STOP_SIGNALS

settings.register_profile("any machine", deadline=None)  # a busy one takes its time
settings.load_profile("any machine")

HERE = Path(__file__).parent
# Tests of whole sites run in rows, one for each folder. Those that only wait for what has to come may run beside
# others, and come first, since they take longest; the loop, whose pace is measured, comes last and alone.
FIRST, LAST = (HERE / "integration", HERE / "browser"), (HERE / "loopback",)


def row_of(path: Path) -> Path | None:
    """The folder in whose row the tests of a file run, if they are of whole sites."""
    return next((folder for folder in FIRST + LAST if folder in path.parents), None)


class WholeSitesInRows(LoadScopeScheduling):
    """Gives each worker whole files, in order, and of whole sites whole rows."""

    def _split_scope(self, nodeid: str) -> str:
        path = nodeid.partition("::")[0]
        return str(row_of(HERE.parent / path) or path)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> WholeSitesInRows:
    """How tests are shared out when two run at once."""
    return WholeSitesInRows(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Rows come first or last, and first of all the tests that leave one pair of sites to each other."""
    items.sort(key=_place)


def _place(item: pytest.Item) -> int:
    row = row_of(item.path)
    if row not in FIRST:
        return len(FIRST) if row is None else len(FIRST) + 1
    return -1 if "pair" in getattr(item, "fixturenames", ()) else FIRST.index(row)


@pytest.fixture(autouse=True)
def signal_handlers_end_with_the_test() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)
