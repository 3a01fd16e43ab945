"""Tracks a simulated arm for an instant before the real one: inner loops are compiled when they first run.

That takes up to a minute once for an installation, and half a second after that, two for the tracker `learned`; no
watchdog and no first pair of frames should have to wait for it.
"""

import sys
from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.hazel import TexturedOperator, film_camera, first_joints_px
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.config import LearnedConfig, MonocularConfig, SilhouetteConfig, StartConfig
from local_site.tracking.registry import tracker_kind
from local_site.tracking.tracker import Tracker, View, Views

INSTANTS = 3
PERIOD_S = 1 / 30
SWING_S = 0.6  # long enough that the arm turns and the tracker learns more of it
EMPTY_INSTANTS = 10  # until the tracker begins to learn the room
PRESENT_INSTANTS = 24  # until it knows the arm and follows it
PRESENT_S = 10.0  # after which the operator has come in and stands still

Pictures = Iterator[Sequence[Image]]


def warm_up(tracking: TrackingConfig) -> None:
    """Track a few instants; of markers only their pictures need it. NotInstalledError where models are missing."""
    scene = tracker_kind(tracking.method).scene
    if scene == "markers":
        SimulatedOperator(SimulationConfig(markers=True)).render(0.0)
        return
    if scene == "textured":
        tracker, pictures = _one_camera(tracking)
    elif scene == "room":
        tracker, pictures = _in_a_room(tracking)
    else:
        tracker, pictures = _before_a_wall(tracking)
    for k, images in enumerate(pictures):
        t_ns = round(k * PERIOD_S * NS_PER_S)
        tracker.track(Views(t_ns, tuple(View(Frame(image, t_ns, k)) for image in images)))


def _before_a_wall(tracking: TrackingConfig) -> tuple[Tracker, Pictures]:
    simulation = SimulationConfig()
    config = replace(tracking, silhouette=SilhouetteConfig(initial_pairs=1))
    tracker = make_tracker(exact_rig(simulation.stereo), config)
    operator = SimulatedOperator(simulation)
    return tracker, (operator.render(k * PERIOD_S) for k in range(INSTANTS))


def _in_a_room(tracking: TrackingConfig) -> tuple[Tracker, Pictures]:
    """A room without the operator, and then with the arm in it."""
    simulation = SimulationConfig(
        room=RoomConfig(scene="office", empty_s=PRESENT_S / 2), motion=MotionConfig(name="toggles", still_s=0.0)
    )
    config = replace(tracking, learned=LearnedConfig(initial_pairs=5))
    tracker = make_tracker(exact_rig(simulation.stereo), config)
    return tracker, _room_pictures(SimulatedOperator(simulation))


def _room_pictures(operator: SimulatedOperator) -> Pictures:
    for _ in range(EMPTY_INSTANTS):
        yield operator.render(0.0, filmed_s=0.0)
    for k in range(PRESENT_INSTANTS):
        yield operator.render(k * PERIOD_S, filmed_s=PRESENT_S)


def _one_camera(tracking: TrackingConfig) -> tuple[Tracker, Pictures]:
    """The swinging arm, started as configured: each start method has inner loops of its own."""
    operator = TexturedOperator(still_s=0.0)
    shoulder, elbow, wrist = first_joints_px().values()
    start = StartConfig(by=tracking.monocular.start.by, shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    tracker = make_tracker(film_camera(), replace(tracking, monocular=MonocularConfig(start=start)))
    return tracker, (operator.render(k * SWING_S, (0,)) for k in range(INSTANTS))


if __name__ == "__main__":
    warm_up(TrackingConfig(method="learned" if "learned" in sys.argv[1:] else "silhouette"))
