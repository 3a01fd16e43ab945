"""What concerns every test: the signal handlers that a command installs end with the test that runs it."""

import signal
from collections.abc import Iterator

import pytest

from common.service import STOP_SIGNALS


@pytest.fixture(autouse=True)
def signal_handlers_end_with_the_test() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in STOP_SIGNALS}
    yield
    for number, handler in before.items():
        if signal.getsignal(number) is not handler:
            signal.signal(number, handler)
