"""What concerns every test: their order when two run at once, no deadlines, signal handlers that end with the test."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from common.service import STOP_SIGNALS

settings.register_profile("any machine", deadline=None)  # a busy one takes its time
settings.load_profile("any machine")

HERE = Path(__file__).parent
ALONE = (HERE / "integration", HERE / "browser")  # in this order: the browser and its sites last to the end


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests of one file stay together, and those that run whole sites come last, one after the other."""
    items.sort(key=_turn)
    for item in items:
        group = "sites" if _turn(item) else str(item.path.relative_to(HERE))
        item.add_marker(pytest.mark.xdist_group(group))


def _turn(item: pytest.Item) -> int:
    return next((turn for turn, folder in enumerate(ALONE, start=1) if folder in item.path.parents), 0)


@pytest.fixture(autouse=True)
def signal_handlers_end_with_the_test() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)
