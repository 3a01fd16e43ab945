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
WHOLE_SITES = (HERE / "integration", HERE / "faults", HERE / "browser")


class WholeSitesInARow(LoadScopeScheduling):
    """Gives each worker whole files, in order; those that run whole sites are one, and so run one after the other."""

    def _split_scope(self, nodeid: str) -> str:
        path = nodeid.partition("::")[0]
        return "whole sites" if any(folder.name in Path(path).parts for folder in WHOLE_SITES) else path


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> WholeSitesInARow:
    """How tests are shared out when two run at once."""
    return WholeSitesInARow(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Those that run whole sites come last, when nothing else is under way."""
    items.sort(key=lambda item: any(folder in item.path.parents for folder in WHOLE_SITES))


@pytest.fixture(autouse=True)
def signal_handlers_end_with_the_test() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)
