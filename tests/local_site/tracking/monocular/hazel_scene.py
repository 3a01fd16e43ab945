"""A few frames of the textured arm before one camera, and a tracker that starts where it is."""

from collections.abc import Sequence
from typing import Literal

from common.cameras.camera import Frame, Image
from local_site.simulation.hazel import Swing, TrueArm, film_camera, film_pixel, hazel_film
from local_site.simulation.textured_arm import Scenery
from local_site.tracking.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import View, Views

RIG = film_camera()
PERIOD_NS = 33_333_333


def arms(count: int, swing: Swing | None = None) -> list[TrueArm]:
    """The first arms of the swing."""
    return [(swing or Swing()).arm(k) for k in range(count)]


def pictures(shown: Sequence[TrueArm], scenery: Scenery | None = None) -> list[Image]:
    """Their pictures."""
    film = hazel_film(scenery)
    return [film.render(arm.limb_poses()) for arm in shown]


def tracker_for(arm: TrueArm, setting: Literal["live", "accurate"] = "live") -> MonocularTracker:
    """A tracker with the joints in the first picture."""
    start = StartConfig(
        shoulder_px=film_pixel(arm.shoulder), elbow_px=film_pixel(arm.elbow), wrist_px=film_pixel(arm.wrist)
    )
    return MonocularTracker(RIG, MonocularConfig(setting=setting, start=start))


def views(picture: Image, k: int) -> Views:
    """The only view of the frame of this number."""
    return Views(k * PERIOD_NS, (View(Frame(picture, k * PERIOD_NS, k)),))
