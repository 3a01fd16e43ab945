"""What the tracker for ordinary rooms has learned of an operator is kept in a file, and the next run begins with it."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from common.cameras.camera import Frame, Image
from common.errors import NotInstalledError
from common.messages.hand import TrackingStatus
from local_site.runtime.profile_file import ProfileStore
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.choice import TrackingConfig, make_tracker, profile_of
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.tracker import Tracker, View, Views

SIMULATION = SimulationConfig(room=RoomConfig(scene="office"), motion=MotionConfig(name="toggles", still_s=1.0))
LEARNING = TrackingConfig(method="learned")
PAIRS = 120


def tracker_with(profile: OperatorProfile | None) -> Tracker:
    try:
        return make_tracker(exact_rig(SIMULATION.stereo), LEARNING, profile)
    except NotInstalledError as missing:
        pytest.skip(str(missing))


def statuses(tracker: Tracker, pictures: Iterator[Sequence[Image]]) -> list[TrackingStatus]:
    found = []
    for k, images in enumerate(pictures):
        t_ns = k * 33_000_000
        found.append(tracker.track(Views(t_ns, tuple(View(Frame(image, t_ns, k)) for image in images))).status)
    return found


@pytest.mark.slow
def test_a_profile_outlasts_the_run_that_learned_it(tmp_path: Path) -> None:
    operator, warnings = SimulatedOperator(SIMULATION), list[str]()
    first = tracker_with(None)
    without = statuses(first, (operator.render(k / 30) for k in range(PAIRS)))
    ProfileStore(str(tmp_path), "anna", warnings.append).save(lambda: profile_of(first))
    known = ProfileStore(str(tmp_path), "anna", warnings.append).known
    assert warnings == []
    assert known is not None
    assert known.forearm_length_m == pytest.approx(SIMULATION.body.forearm_length, rel=0.08)
    again = statuses(tracker_with(known), (operator.render(k / 30) for k in range(30)))
    assert again.index(TrackingStatus.TRACKED) <= without.index(TrackingStatus.TRACKED)
