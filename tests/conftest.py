"""What concerns every test: their order when two run in parallel, no deadlines, handlers that end with the test."""

import gc
import os
import signal
import sys
import threading
from collections.abc import Generator, Iterator
from functools import cache
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from common.process.service import STOP_SIGNALS

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # the workers already fill the processors
settings.register_profile("any machine", deadline=None, derandomize=True)  # a busy one takes its time
settings.register_profile("other examples", deadline=None)  # for `make long`
settings.load_profile("any machine")

HERE = Path(__file__).parent
PATIENCE_S = 3600.0  # with tests that take long; pyproject.toml has the others' timeout
# Tests of light sites, which only wait for events, run in one row beside others, and first, since they take longest.
FIRST = (HERE / "integration",)
IN_A_ROOM = HERE / "loopback" / "test_loopback_in_a_room.py"
# Where pace is measured (page, loop, links) tests come last, in one row too, and beside them only such as mostly wait.
# Playwright leaves a running event loop behind it, besides: what comes after it must not need its own.
LAST = (
    HERE / "faults",
    HERE / "examples",
    HERE / "browser",
    HERE / "loopback" / "test_loopback.py",
    HERE / "loopback" / "test_dying_site.py",
    IN_A_ROOM,
    HERE / "farhand" / "doctor" / "link",
    HERE / "lab" / "measure" / "wan",
)
WAITING = (
    HERE / "common" / "link" / "test_link_refusals.py",
    HERE / "farhand" / "test_router.py",
    HERE / "farhand" / "authority",
    HERE / "common" / "link",
    HERE / "farhand" / "certificates",
    HERE / "common" / "process" / "test_life.py",
    HERE / "farhand" / "doctor",
)


@cache
def place_of(path: Path) -> Path | None:
    """The folder or file of those above that a file of tests belongs to."""
    return next((place for place in FIRST + LAST + WAITING if place == path or place in path.parents), None)


class WholeSitesInRows(LoadScopeScheduling):  # type: ignore[misc]  # xdist has no types
    """Gives each worker whole files, in order, and of whole sites a whole row: all that come last are one."""

    def _split_scope(self, nodeid: str) -> str:
        path = nodeid.partition("::")[0]
        place = place_of(HERE.parent / path)
        if place in LAST:
            return "last"
        return str(place) if place in FIRST else path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> WholeSitesInRows:
    """Distribute the tests when two run in parallel."""
    return WholeSitesInRows(config, log)


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage among what is imported, neither meanwhile nor in any test."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Sort rows first or last, first of all tests that leave one pair of sites to each other; some may take hours."""
    items.sort(key=_rank)
    for item in items:
        if item.get_closest_marker("long") or item.get_closest_marker("faults"):
            item.add_marker(pytest.mark.timeout(PATIENCE_S))


def _rank(item: pytest.Item) -> int:
    place = place_of(item.path)
    if place is None:
        return 0
    if place in FIRST:
        return -2 if "pair" in getattr(item, "fixturenames", ()) else -1
    return 1 + (LAST + WAITING).index(place)


@pytest.fixture(autouse=True)
def signal_handlers_end_with_the_test() -> Iterator[None]:
    """Put back the handlers of the signals that stop a service."""
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)


@pytest.fixture(autouse=True)
def error_hooks_end_with_the_test() -> Iterator[None]:
    """Put back what shows the error of a thread: here pytest's own, which fails the test."""
    before = sys.excepthook, threading.excepthook
    yield
    sys.excepthook, threading.excepthook = before


@pytest.fixture(autouse=True)
def scheduling_stays() -> Iterator[None]:
    """Fail a test that leaves this process in real time: all later ones and their processes would starve the rest."""
    before = os.sched_getscheduler(0)
    yield
    left = os.sched_getscheduler(0)
    os.sched_setscheduler(0, before, os.sched_param(0))
    assert left == before, "the test asked for real time in the process of the tests"
