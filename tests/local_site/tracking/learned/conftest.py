"""The tracker with its real networks, and what it is shown in several tests, filmed once."""

import pytest

from common.errors import ModelError
from local_site.calibration.rig import Rig
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.config import LearnedConfig
from local_site.tracking.learned.learned_tracker import LearnedTracker
from tests.local_site.tracking.learned.office_films import EMPTY_S, MakeTracker, filmed, office
from tests.local_site.tracking.rendered_arm import PAIR, Sequence, rig_of


@pytest.fixture(scope="session")
def make_tracker() -> MakeTracker:
    """Makes trackers with the installed models; without them the test is skipped with the cure as the reason."""
    try:
        LearnedTracker(rig_of([camera.projection for camera in PAIR]))
    except ModelError as error:
        pytest.skip(str(error))

    def make(rig: Rig, config: LearnedConfig | None = None) -> LearnedTracker:
        return LearnedTracker(rig, config)

    return make


@pytest.fixture(scope="session")
def carrying() -> Sequence:
    """An operator comes into the empty office and carries something about."""
    return filmed(office(RoomConfig(scene="office", empty_s=EMPTY_S)), 95)
