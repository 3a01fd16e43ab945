"""What the tests of whole sites in a file share: one pair of them."""

from collections.abc import Iterator

import pytest

from tests.integration.pair import Pair
from tests.integration.sites import pytest_runtest_makereport, running_sites

__all__ = ["pytest_runtest_makereport"]


@pytest.fixture(scope="module")
def pair() -> Iterator[Pair]:
    """Both sites, as the last test left them."""
    with running_sites() as sites:
        yield Pair(sites)
