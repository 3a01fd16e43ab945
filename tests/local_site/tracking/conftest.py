"""Sequences that several tests share, rendered once."""

import pytest

from tests.local_site.tracking.rendered_arm import (
    ABOVE,
    ASIDE,
    MOVING,
    PAIR,
    TURNING,
    Sequence,
    render_sequence,
)


@pytest.fixture(scope="session")
def moving() -> Sequence:
    """The arm on a figure of eight before two cameras."""
    return render_sequence(MOVING, 45)


@pytest.fixture(scope="session")
def turning() -> Sequence:
    """The hand turning about an axis before two cameras."""
    return render_sequence(TURNING, 75)


@pytest.fixture(scope="session")
def surrounded() -> Sequence:
    """The arm on a figure of eight before four cameras."""
    return render_sequence(MOVING, 20, (*PAIR, ABOVE, ASIDE))
