"""Rendered sequences of the simulated arm before any number of cameras, and trackers fed with them."""

from collections import abc
from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Frame, Image
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration, Rig, Row4
from local_site.simulation.body import ArmBody, ArmTruth
from local_site.simulation.cameras import PinholeCamera, stereo_pair
from local_site.simulation.config import BodyConfig, MotionConfig, PictureConfig, StereoConfig
from local_site.simulation.motion import Motion
from local_site.simulation.rendering import Renderer
from local_site.tracking.tracker import ArmEstimate, Tracker, View, Views

Pictures = tuple[Image, ...]
Change = abc.Callable[[Pictures], abc.Iterable[Image]]

PERIOD_S = 1 / 30
STEREO = StereoConfig()
PAIR = stereo_pair(STEREO)
ABOVE = stereo_pair(StereoConfig(half_angle_deg=8.0, elevation_deg=45.0))[1]
ASIDE = stereo_pair(StereoConfig(half_angle_deg=45.0, elevation_deg=5.0))[0]
POINTS = ("elbow", "wrist", "index", "thumb")
EVERYWHERE = 50.0


@dataclass(frozen=True)
class Sequence:
    """What cameras with these projections see: `pictures[k]` are those of all cameras at `times_s[k]`."""

    projections: tuple[Array, ...]
    times_s: tuple[float, ...]
    pictures: tuple[Pictures, ...]
    truths: tuple[ArmTruth, ...]

    def views(self, k: int, change: Change = tuple) -> Views:
        """The views of the k-th instant, after a change to its pictures."""
        t_ns = round(self.times_s[k] * 1e9)
        return Views(t_ns, tuple(View(Frame(image, t_ns, k)) for image in change(self.pictures[k])))

    def between(self, k: int, camera: int, late_s: float) -> View:
        """The view at the k-th instant of a camera that exposes later, from its exposures before and after."""
        now, before = (Frame(self.pictures[n][camera], round((self.times_s[n] + late_s) * 1e9), n) for n in (k, k - 1))
        return View(now, before, weight=1 - late_s / PERIOD_S)

    def tracked(self, tracker: Tracker, change: Change = tuple) -> list[ArmEstimate]:
        """The estimates of all instants."""
        return [tracker.track(self.views(k, change)) for k in range(len(self.times_s))]


def render_sequence(
    motion: MotionConfig,
    count: int,
    cameras: abc.Sequence[PinholeCamera] = PAIR,
    body: BodyConfig | None = None,
    late_s: float = 0.0,
    since_s: float = 0.0,
) -> Sequence:
    """The arm at `count` instants a period apart; camera k exposes k times `late_s` later than the first."""
    body = body or BodyConfig()
    course, arm = Motion(motion, body, 1), ArmBody(body)
    renderers = [Renderer(camera, arm.parts, STEREO, PictureConfig(), 1 + k) for k, camera in enumerate(cameras)]
    times = tuple(since_s + k * PERIOD_S for k in range(count))
    return Sequence(
        projections=tuple(camera.projection for camera in cameras),
        times_s=times,
        pictures=tuple(
            tuple(r.render([arm.solid(course.pose(t + k * late_s))]) for k, r in enumerate(renderers)) for t in times
        ),
        truths=tuple(arm.truth(course.pose(t)) for t in times),
    )


def rig_of(projections: abc.Sequence[Array], reach_m: float = EVERYWHERE) -> Rig:
    """An exact rig whose volume reaches as far in all directions."""
    cameras = tuple(CameraCalibration(f"camera {k}", rows_of(m), 0.0) for k, m in enumerate(projections))
    low, high = (-reach_m, -reach_m, -reach_m), (reach_m, reach_m, reach_m)
    return Rig(cameras, low, high, (0.0, 0.0, 0.0), "exact, simulated")


def rows_of(projection: Array) -> tuple[Row4, Row4, Row4]:
    """A projection (3, 4) as a rig holds it."""
    rows: list[Row4] = [(a, b, c, d) for a, b, c, d in projection.tolist()]
    return rows[0], rows[1], rows[2]


def errors_m(estimates: abc.Sequence[object], truths: abc.Sequence[object], name: str) -> Array:
    """Errors (N, 3) of a point in m; every estimate must have it."""
    return np.array([getattr(e, name) - getattr(t, name) for e, t in zip(estimates, truths, strict=True)])


def apart_m(first: abc.Sequence[object], second: abc.Sequence[object], name: str) -> float:
    """The mean distance in m of a point between two runs."""
    return float(np.linalg.norm(errors_m(first, second, name), axis=1).mean())


def motion_error_m(errors: Array) -> float:
    """Mean distance in m of errors (N, 3) from their mean: what is left when a constant offset is taken away."""
    return float(np.linalg.norm(errors - errors.mean(axis=0), axis=1).mean())


BRISK_S = 2.5
MOVING = MotionConfig(name="figure_of_eight", still_s=0.4)
TURNING = MotionConfig(name="rotate_x", still_s=0.4)
