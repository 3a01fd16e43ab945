"""A few frames of the textured arm before one camera, and a tracker that starts where it is."""

from common.cameras.camera import Frame
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.simulation.hazel import FOCAL_PX, SIZE_PX, Swing, hazel_film
from local_site.tracking.monocular.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import View, Views

U, V = (SIZE_PX[0] - 1) / 2, (SIZE_PX[1] - 1) / 2
ROWS = (FOCAL_PX, 0.0, U, 0.0), (0.0, FOCAL_PX, V, 0.0), (0.0, 0.0, 1.0, 0.0)
RIG = Rig(
    (CameraCalibration("left", ROWS, 0.0, size_px=SIZE_PX),), (-1.0, -1.0, 0.5), (1.0, 1.0, 2.0), (0.0,) * 3, "drawn"
)
PERIOD_NS = 33_333_333


def arms(count, swing=None):
    """The first arms of the swing."""
    return [(swing or Swing()).arm(k) for k in range(count)]


def pictures(shown, scenery=None):
    """Their pictures."""
    film = hazel_film(scenery)
    return [film.render(arm.places()) for arm in shown]


def seen_at(point):
    """Where the camera sees a point, px."""
    return float(FOCAL_PX * point[0] / point[2] + U), float(FOCAL_PX * point[1] / point[2] + V)


def tracker_for(arm, setting="live"):
    """A tracker that is told where the joints are in the first picture."""
    start = StartConfig(shoulder_px=seen_at(arm.shoulder), elbow_px=seen_at(arm.elbow), wrist_px=seen_at(arm.wrist))
    return MonocularTracker(RIG, MonocularConfig(setting=setting, start=start))


def views(picture, k):
    """The only view of the frame of this number."""
    return Views(k * PERIOD_NS, (View(Frame(picture, k * PERIOD_NS, k)),))
