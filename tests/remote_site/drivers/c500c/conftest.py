"""The emulated A465 that most tests here begin with."""

import pytest

from tests.remote_site.drivers.c500c.emulated_a465 import EmulatedA465


@pytest.fixture
def bench() -> EmulatedA465:
    return EmulatedA465()
