"""The supervised robot that most tests here begin with."""

import pytest

from tests.remote_site.drivers.supervisor.supervised import Supervised


@pytest.fixture
def rig() -> Supervised:
    return Supervised()
