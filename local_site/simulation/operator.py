"""Simulated operators: what all have in common, the one with a bare arm or markers, and how one is made."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.simulation.body import ArmBody, ArmTruth, BodyPose, MarkedArm
from local_site.simulation.cameras import PinholeCamera, exact_rig, stereo_pair
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hand import POSTURES
from local_site.simulation.hazel import TexturedOperator, film_camera
from local_site.simulation.motion import Motion, Path, minimum_jerk
from local_site.simulation.rendering import Renderer
from local_site.simulation.room.room_view import room_views

SUB_FRAMES = 3
COMES_FROM_M, COMES_IN_S = (1.2, 0.0, 0.0), 0.8  # an operator whom the cameras awaited steps in from the side


class Operator(Protocol):
    """An operator who moves in front of cameras; times are s since the start of the motion.

    `filmed_s` is the time since the cameras began, for what happens in the room by itself; if None, `t_s`.
    `points` are those that a tracker measures, by name, (3,) in m in the operator frame.
    """

    def render(self, t_s: float, cameras: tuple[int, ...], filmed_s: float | None = None) -> list[Image]: ...

    def points(self, t_s: float) -> Mapping[str, Array]: ...

    def openings_until(self, t_s: float) -> int: ...


def make_operator(config: SimulationConfig, path: Path | None = None) -> Operator:
    """The operator that the configuration asks for; ConfigError when the motion is out of the arm's reach.

    An operator that is not textured moves along `path` where one is given.
    """
    return TexturedOperator(config.motion.still_s) if config.textured else SimulatedOperator(config, path)


def filming_rig(config: SimulationConfig) -> Rig:
    """The cameras that film this operator, without any error."""
    return film_camera() if config.textured else exact_rig(config.stereo)


class SimulatedOperator:
    """A right arm, bare or with markers, that moves before two cameras; times are s since the start of the motion.

    It moves along `path` where one is given, else as the configuration names it.
    """

    def __init__(self, config: SimulationConfig, path: Path | None = None) -> None:
        self.motion = Motion(config.motion, config.body, config.seed, path)
        self._skin = ArmBody(config.body, POSTURES[config.motion.posture])
        self._body = MarkedArm(self._skin, config.markers_worn) if config.markers else self._skin
        self._empty_s = config.room.empty_s
        self._shutter_s = config.picture.shutter_ms * 1e-3
        cameras = stereo_pair(config.stereo)
        self._views: Sequence[_View] = (
            room_views(cameras, self._skin, config)
            if config.room.scene == "office"
            else [_DarkView(camera, self._body, config, config.seed + k) for k, camera in enumerate(cameras)]
        )

    def render(self, t_s: float, cameras: tuple[int, ...] = (0, 1), filmed_s: float | None = None) -> list[Image]:
        """The pictures of these cameras (0 left, 1 right), exposed about this time: (H, W) grey in the dark, else
        (H, W, 3) BGR."""
        now_s = t_s if filmed_s is None else filmed_s
        offsets = [(k + 0.5) / SUB_FRAMES - 0.5 for k in range(SUB_FRAMES)] if self._shutter_s else [0.0]
        poses = [self.pose(t_s + offset * self._shutter_s, now_s + offset * self._shutter_s) for offset in offsets]
        return [self._views[camera].render(poses if now_s >= self._empty_s else [], now_s) for camera in cameras]

    def pose(self, t_s: float, filmed_s: float | None = None) -> BodyPose:
        """The arm's pose at this time: as the motion has it, but for an operator who has only just come in."""
        pose = self.motion.pose(t_s)
        present_s = (t_s if filmed_s is None else filmed_s) - self._empty_s
        if not self._empty_s or present_s >= COMES_IN_S:
            return pose
        away = (1.0 - minimum_jerk(present_s / COMES_IN_S)) * np.array(COMES_FROM_M)
        return replace(pose, shoulder=pose.shoulder + away, elbow=pose.elbow + away, wrist=pose.wrist + away)

    def truth(self, t_s: float, filmed_s: float | None = None) -> ArmTruth:
        """The points to be found at this time."""
        return self._body.truth(self.pose(t_s, filmed_s))

    def joints(self, t_s: float, filmed_s: float | None = None) -> Array:
        """Joint centres (5, 4, 3) of index, middle, ring, little finger and thumb, from base to tip."""
        return self._skin.joints(self.pose(t_s, filmed_s))

    def points(self, t_s: float) -> Mapping[str, Array]:
        """The points of the truth by name, of an operator who has come in."""
        truth = self._body.truth(self.motion.pose(t_s))
        return {"elbow": truth.elbow, "wrist": truth.wrist, "index": truth.index, "thumb": truth.thumb}

    def openings_until(self, t_s: float) -> int:
        """Count how often the hand has begun to open by this time."""
        return self.motion.openings_until(t_s)


class _View(Protocol):
    """One camera's pictures of an operator in poses spread over one exposure, or in none while not there."""

    def render(self, poses: Sequence[BodyPose], filmed_s: float) -> Image: ...


class _DarkView:
    """The arm alone, grey before black cloth."""

    def __init__(self, camera: PinholeCamera, body: ArmBody | MarkedArm, config: SimulationConfig, seed: int) -> None:
        self._body = body
        self._renderer = Renderer(camera, body.parts, config.stereo, config.picture, seed)

    def render(self, poses: Sequence[BodyPose], filmed_s: float) -> Image:
        del filmed_s
        return self._renderer.render([self._body.solid(pose) for pose in poses])
