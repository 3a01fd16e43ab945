"""What concerns every test: their order when two run in parallel, no deadlines, handlers that end with the test."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from common.process.service import STOP_SIGNALS

settings.register_profile("any machine", deadline=None)  # a busy one takes its time
settings.load_profile("any machine")

HERE = Path(__file__).parent
# Tests of whole sites run in rows, one for each folder. Those of light sites, which only wait for events, run beside
# others, and first, since they take longest; the page and the loop, whose pace is measured, come last and alone.
FIRST, LAST = (HERE / "integration",), (HERE / "faults", HERE / "browser", HERE / "loopback")


def row_of(path: Path) -> Path | None:
    """The folder in whose row the tests of a file run, if they are of whole sites."""
    return next((folder for folder in FIRST + LAST if folder in path.parents), None)


class WholeSitesInRows(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Gives each worker whole files, in order, and of whole sites a whole row: all that come last are one."""

    def _split_scope(self, nodeid: str) -> str:
        path = nodeid.partition("::")[0]
        row = row_of(HERE.parent / path)
        return "last" if row in LAST else str(row or path)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> WholeSitesInRows:
    """Distribute the tests when two run in parallel."""
    return WholeSitesInRows(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort the rows first or last, and first of all the tests that leave one pair of sites to each other."""
    items.sort(key=_rank)


def _rank(item: pytest.Item) -> int:
    row = row_of(item.path)
    if row is None:
        return 0
    if row in LAST:
        return 1 + LAST.index(row)
    return -2 if "pair" in getattr(item, "fixturenames", ()) else -1


@pytest.fixture(autouse=True)
def signal_handlers_end_with_the_test() -> Iterator[None]:
    """Put back the handlers of the signals that stop a service."""
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)
