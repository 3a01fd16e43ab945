"""The simulated operator filmed in an office, for trackers with real networks; and how well a film was tracked."""

from collections.abc import Callable
from collections.abc import Sequence as Several
from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from common.messages.hand import TrackingStatus
from local_site.simulation.body import ArmBody
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.hand import POSTURES
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from local_site.simulation.room.room_view import room_views
from local_site.tracking.learned.learned_tracker import LearnedTracker
from local_site.tracking.tracker import ArmEstimate
from tests.local_site.tracking.rendered_arm import PAIR, PERIOD_S, Pictures, Sequence, rig_of

EMPTY_S = 1.3
CARRY = MotionConfig(name="pick_and_place", still_s=0.3)
MakeTracker = Callable[..., LearnedTracker]


def office(room: RoomConfig, motion: MotionConfig = CARRY) -> SimulationConfig:
    """The simulated operator in a room."""
    return SimulationConfig(motion=motion, room=room)


def filmed(
    config: SimulationConfig, count: int, cameras: Several[PinholeCamera] = PAIR, late_s: float = 0.0
) -> Sequence:
    """`count` instants a period apart; camera k exposes k times `late_s` later than the first."""
    operator, body = SimulatedOperator(config), ArmBody(config.body, POSTURES[config.motion.posture])
    views, empty_s = room_views(cameras, body, config), config.room.empty_s
    times = tuple(k * PERIOD_S for k in range(count))

    def picture(camera: int, t_s: float) -> Image:
        poses = [operator.pose(max(t_s - empty_s, 0.0), t_s)] if t_s >= empty_s else []
        return views[camera].render(poses, t_s)

    return Sequence(
        projections=tuple(camera.projection for camera in cameras),
        times_s=times,
        pictures=tuple(tuple(picture(k, t + k * late_s) for k in range(len(cameras))) for t in times),
        truths=tuple(operator.truth(max(t - empty_s, 0.0), t) for t in times),
    )


def mirrored(pictures: Pictures) -> Pictures:
    """A pair mirrored and exchanged: the same rig then sees a left arm."""
    left, right = pictures
    return np.ascontiguousarray(right[:, ::-1]), np.ascontiguousarray(left[:, ::-1])


@dataclass(frozen=True)
class Tracked:
    """The estimates of a film's instants, and its truth."""

    estimates: Several[ArmEstimate]
    sequence: Sequence

    def share(self, since: int) -> float:
        """How many of the instants from one on are tracked."""
        return float(np.mean([e.status is TrackingStatus.TRACKED for e in self.estimates[since:]]))

    def errors_mm(self, name: str) -> Array:
        """The errors (N,) of a point where it is tracked."""
        off = [
            getattr(estimate, name) - getattr(truth, name)
            for estimate, truth in zip(self.estimates, self.sequence.truths, strict=True)
            if estimate.status is TrackingStatus.TRACKED and getattr(estimate, name) is not None
        ]
        errors: Array = 1e3 * np.linalg.norm(np.array(off).reshape(-1, 3), axis=1)
        return errors

    @property
    def statuses(self) -> set[TrackingStatus]:
        """Which statuses there are."""
        return {estimate.status for estimate in self.estimates}


def track(make: MakeTracker, sequence: Sequence) -> Tracked:
    """All instants of a film, tracked."""
    return Tracked(sequence.tracked(make(rig_of(sequence.projections))), sequence)
