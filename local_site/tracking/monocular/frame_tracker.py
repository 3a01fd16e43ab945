"""Tracks the arm from frame to frame in one camera's pictures: predict, select visible points, fit, learn new ones."""

import math

import numpy as np

from common.cameras.camera import Image
from local_site.calibration.physical_camera import Lens
from local_site.kernels.pictures import greys_at
from local_site.tracking.config import MonocularConfig
from local_site.tracking.monocular.arm_model import (
    MM,
    ArmPose,
    ArmView,
    Depths,
    forearm_mesh,
    predicted,
    upper_arm_mesh,
)
from local_site.tracking.monocular.estimator import (
    ACCURATE,
    COARSE,
    LIVE,
    EstimatorScene,
    EstimatorSetting,
    EstimatorState,
    MotionFit,
    fit_arm,
)
from local_site.tracking.monocular.picture import Box, PyramidLevel, coarse_level, fine_level, in_coarse_px
from local_site.tracking.monocular.skin import Skin

SEED = 1
LEAST_GRADIENT = 20.0 / 8.0
FACING, NEW_FACING = 0.45, 0.6
LEARN_AFTER = math.cos(math.radians(6.0))
ENOUGH_NEAR = 0.9
EVEN_LIGHT = np.array([1.0, 0.0, 0.0, 0.0])


class ArmFrameTracker:
    """Both links' meshes and skins, and the arm's state in the last two frames; `last` is where it was last found."""

    def __init__(self, lens: Lens, config: MonocularConfig, setting: EstimatorSetting | None = None) -> None:
        """The default setting is the configuration's."""
        upper_arm, forearm = upper_arm_mesh(config.upper_arm), forearm_mesh(config.forearm)
        self._lens = lens
        self._view = ArmView(lens, upper_arm, forearm)
        self._skins = Skin(upper_arm, SEED), Skin(forearm, SEED + 1)
        self._setting = setting or (ACCURATE if config.setting == "accurate" else LIVE)
        self._variances = np.array([config.noise.grey**2, *[(MM * config.noise.position_mm) ** 2] * 3])
        self._learned_from = [np.zeros(3), np.zeros(3)]
        self._last_level: tuple[Box, PyramidLevel] | None = None
        self._before: EstimatorState | None = None
        self.last: EstimatorState | None = None

    def begin(self, image: Image, pose: ArmPose) -> bool:
        """Learn the skin in a picture (H, W) in which the pose is known; False if the arm is out of the picture."""
        state = EstimatorState(pose, EVEN_LIGHT, EVEN_LIGHT)
        if not self._learn(image, state, FACING):
            return False
        self.rest_at(state)
        return True

    def rest_at(self, state: EstimatorState) -> None:
        """Set the last state, with no motion."""
        self._before = self.last = state

    def expected(self) -> EstimatorState | None:
        """The predicted state in the next frame; None before `begin`."""
        if self.last is None or self._before is None:
            return None
        return EstimatorState(predicted(self._before.pose, self.last.pose), *self.last.lights)

    def fit(self, image: Image, start: EstimatorState) -> MotionFit | None:
        """The maximum likelihood state in a picture (H, W), through the coarse level if the fine one alone fits badly.

        None if the arm is out of the picture.
        """
        box = self._view.box(start.pose, image.shape)
        if box is None:
            return None
        fine, depths = fine_level(image, self._lens, box), self._view.depths(start.pose, box)
        self._last_level = box, fine
        direct = fit_arm(self._scene(fine, start, depths, False), start, self._setting)
        if direct.equations.near.min() >= ENOUGH_NEAR:
            return direct
        rough = fit_arm(self._scene(coarse_level(image, self._lens, box), start, depths, True), start, COARSE)
        again = fit_arm(self._scene(fine, rough.state, depths, False), rough.state, self._setting)
        return max(direct, again, key=lambda fit: float(fit.equations.near.min()))

    def move_to(self, state: EstimatorState) -> None:
        """Set the arm's state without learning from it."""
        self._before, self.last = self.last, state

    def keep(self, image: Image, fit: MotionFit) -> None:
        """Set the arm's state to a fit, and learn the skin that came into view."""
        self.move_to(fit.state)
        self._learn(image, fit.state, NEW_FACING)

    def _scene(self, level: PyramidLevel, state: EstimatorState, depths: Depths, is_coarse: bool) -> EstimatorScene:
        facing, most = (NEW_FACING, COARSE.points) if is_coarse else (FACING, self._setting.points)
        upper, forearm = (
            skin.surface_in_view(link, depths, facing, most, is_coarse)
            for skin, link in zip(self._skins, state.pose.links, strict=True)
        )
        return EstimatorScene(level, upper, forearm, self._variances)

    def _learn(self, image: Image, state: EstimatorState, facing: float) -> bool:
        """Learn the visible skin of every link that has rotated since; False if the arm is out of view.

        Points with a clear gradient that face the camera and are not known yet; the reflectance is grey by light.
        """
        sights = [rotation.T @ (joint / np.linalg.norm(joint)) for joint, rotation in state.pose.links]
        due = [k for k in range(2) if sights[k] @ self._learned_from[k] < LEARN_AFTER]
        if not due:
            return True
        box = self._view.box(state.pose, image.shape)
        if box is None:
            return False
        if self._last_level is None:
            self._last_level = box, fine_level(image, self._lens, box)
        box, fine = self._last_level  # around the expected arm: its margin covers the motion since
        coarse = coarse_level(image, self._lens, box)
        patches = self._view.patches(state.pose, box)
        for k in due:
            skin, patch, light, (_, rotation) = self._skins[k], patches[k], state.lights[k], state.pose.links[k]
            slope = np.hypot(fine.along_x[patch.rows, patch.columns], fine.along_y[patch.rows, patch.columns])
            new = (slope > LEAST_GRADIENT) & (patch.facing > facing) & skin.unknown(patch.points)
            rows, columns, normals = patch.rows[new], patch.columns[new], patch.normals[new]
            lit = light[0] + normals @ rotation.T @ light[1:]
            grey = fine.grey[rows, columns].astype(np.float64)
            rough = greys_at(coarse.grey, in_coarse_px(columns), in_coarse_px(rows))
            skin.learn(patch.points[new], normals, grey / lit, rough / lit)
            self._learned_from[k] = sights[k]
        return True
