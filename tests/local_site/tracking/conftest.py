"""Sequences that several tests share, rendered once."""

import pytest

from tests.local_site.tracking.rendered_arm import (
    ABOVE,
    ASIDE,
    MOVING,
    PAIR,
    TURNING,
    render_sequence,
)


@pytest.fixture(scope="session")
def moving():
    """The arm on a figure of eight before two cameras."""
    return render_sequence(MOVING, 45)


@pytest.fixture(scope="session")
def turning():
    """The hand turning about an axis before two cameras."""
    return render_sequence(TURNING, 75)


@pytest.fixture(scope="session")
def surrounded():
    """The arm on a figure of eight before four cameras."""
    return render_sequence(MOVING, 20, (*PAIR, ABOVE, ASIDE))
