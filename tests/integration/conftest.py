"""Compiles the tracker before any test waits for a site to start."""

import pytest

from local_site.tracking.choice import TrackingConfig
from local_site.warm_up import warm_up


@pytest.fixture(scope="session", autouse=True)
def tracker_is_compiled() -> None:
    warm_up(TrackingConfig())
