"""Which operator is simulated: what all have in common, the one with a bare arm or markers, and how one is made."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.simulation.body import ArmBody, ArmTruth, BodyPose, MarkedArm
from local_site.simulation.cameras import PinholeCamera, exact_rig, stereo_pair
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hand import POSTURES
from local_site.simulation.hazel import TexturedOperator, film_camera
from local_site.simulation.motion import Motion
from local_site.simulation.rendering import Renderer
from local_site.simulation.room.room_view import RoomView

SUB_FRAMES = 3


class Operator(Protocol):
    """An operator who moves in front of cameras; times are s since the start of the motion.

    `points` are those that a tracker measures, by name, (3,) in m in the operator frame.
    """

    def render(self, t_s: float, cameras: tuple[int, ...]) -> list[Image]: ...

    def points(self, t_s: float) -> Mapping[str, Array]: ...

    def openings_until(self, t_s: float) -> int: ...


def make_operator(config: SimulationConfig) -> Operator:
    """The operator that the configuration asks for; ConfigError when the motion is out of the arm's reach."""
    return TexturedOperator(config.motion.still_s) if config.textured else SimulatedOperator(config)


def filming_rig(config: SimulationConfig) -> Rig:
    """The cameras that film this operator, without any error."""
    return film_camera() if config.textured else exact_rig(config.stereo)


class SimulatedOperator:
    """A right arm, bare or with markers, that moves before two cameras; times are s since the start of the motion."""

    def __init__(self, config: SimulationConfig) -> None:
        self.motion = Motion(config.motion, config.body, config.seed)
        body = ArmBody(config.body, POSTURES[config.motion.posture])
        self._body = MarkedArm(body) if config.markers else body
        self._shutter_s = config.picture.shutter_ms * 1e-3
        self._views: list[_View] = [
            RoomView(camera, body, config, config.seed + k)
            if config.room.scene == "office"
            else _DarkView(camera, self._body, config, config.seed + k)
            for k, camera in enumerate(stereo_pair(config.stereo))
        ]

    def render(self, t_s: float, cameras: tuple[int, ...] = (0, 1)) -> list[Image]:
        """The pictures of these cameras (0 left, 1 right), exposed about this time: (H, W) grey in the dark, else
        (H, W, 3) BGR."""
        offsets = [(k + 0.5) / SUB_FRAMES - 0.5 for k in range(SUB_FRAMES)] if self._shutter_s else [0.0]
        poses = [self.motion.pose(t_s + offset * self._shutter_s) for offset in offsets]
        return [self._views[camera].render(poses) for camera in cameras]

    def truth(self, t_s: float) -> ArmTruth:
        """The points to be found at this time."""
        return self._body.truth(self.motion.pose(t_s))

    def points(self, t_s: float) -> Mapping[str, Array]:
        """The same by name."""
        truth = self.truth(t_s)
        return {"elbow": truth.elbow, "wrist": truth.wrist, "index": truth.index, "thumb": truth.thumb}

    def openings_until(self, t_s: float) -> int:
        """How often the hand has begun to open by this time."""
        return self.motion.openings_until(t_s)


class _View(Protocol):
    """One camera's pictures of an operator in poses spread over one exposure."""

    def render(self, poses: Sequence[BodyPose]) -> Image: ...


class _DarkView:
    """The arm alone, grey before black cloth."""

    def __init__(self, camera: PinholeCamera, body: ArmBody | MarkedArm, config: SimulationConfig, seed: int) -> None:
        self._body = body
        self._renderer = Renderer(camera, body.parts, config.stereo, config.picture, seed)

    def render(self, poses: Sequence[BodyPose]) -> Image:
        return self._renderer.render([self._body.solid(pose) for pose in poses])
