"""An operator with a textured arm before one camera: swings as in HAZEL-S, on and on, at the report's 30 frames a second."""

from collections.abc import Mapping

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.hazel import FOREARM_M, PALM_POINT_M, Swing, TrueArm, film_pixel, hazel_film

JOINTS = ("shoulder", "elbow", "wrist")
FRAMES_PER_S = 30.0
LIVE_FINE = 1  # rendered while it is filmed, so that there is no time for finer pictures


class TexturedOperator:
    """Stands still for `still_s`, then swings; the camera's frame is the operator's."""

    def __init__(self, still_s: float) -> None:
        self._film = hazel_film(fine=LIVE_FINE)
        self._still_s = still_s
        self._swing = Swing()

    def render(self, t_s: float, cameras: tuple[int, ...] = (0,)) -> list[Image]:
        """The picture (H, W) grey, once for each camera that is asked for."""
        return [self._film.render(self._arm(t_s).places()) for _ in cameras]

    def points(self, t_s: float) -> Mapping[str, Array]:
        """The points to be found at this time."""
        arm = self._arm(t_s)
        return {"elbow": arm.elbow, "wrist": arm.wrist, "palm": arm.along_forearm(FOREARM_M + PALM_POINT_M)}

    def openings_until(self, t_s: float) -> int:
        """Its hand never opens."""
        del t_s
        return 0

    def _arm(self, t_s: float) -> TrueArm:
        return self._swing.arm(FRAMES_PER_S * max(t_s - self._still_s, 0.0))


def first_joints_px() -> Mapping[str, tuple[float, float]]:
    """Where the joints are in the first picture, px: what a person would click."""
    arm = Swing().arm(0.0)
    return {name: film_pixel(point) for name, point in zip(JOINTS, (arm.shoulder, arm.elbow, arm.wrist), strict=True)}
