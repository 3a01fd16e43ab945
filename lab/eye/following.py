"""An arm followed through a film by the networks alone, from a first place that is given: no fit, no dynamics."""

import numpy as np
import torch
from numpy.typing import NDArray

from common.geometry import Array
from lab.eye.arms.surface import CropKind
from lab.eye.arms.views import CROP_M
from lab.eye.network import EyeNetwork
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import image_of, project, triangulate_many
from local_site.tracking.eye.arm_points import KNUCKLES, MIDDLE_KNUCKLE, WRIST
from local_site.tracking.eye.crops import crop_about

Picture = NDArray[np.uint8]
PALM_M = 0.09  # from the wrist to the knuckles, where only the fingertips are known


def begun_at(wrist: Array, index: Array, elbow: Array) -> Array:
    """Guess the 22 points (22, 3) in m of an arm of which three are known: all knuckles lie towards the index's tip."""
    towards = (index - wrist) / np.linalg.norm(index - wrist)
    points = np.tile(wrist + PALM_M * towards, (22, 1))
    points[0], points[WRIST] = elbow, wrist
    return points


class EyeFollower:
    """Follows an arm before a rig: each view's crops lie where the last points were."""

    def __init__(self, rig: Rig, networks: dict[CropKind, EyeNetwork]) -> None:
        self._cameras = rig.cameras
        self._networks = networks

    def followed(self, points: Array, pictures: list[Picture]) -> Array:
        """Find the points (22, 3) in m in pictures (H, W, 3) BGR, one of each camera, from where they were before.

        Elbow and wrist come of the arm's network, the hand's landmarks of the hand's.
        """
        pixels: dict[CropKind, list[Array]] = {"arm": [], "hand": []}
        for camera, picture in zip(self._cameras, pictures, strict=True):
            for kind, found in pixels.items():
                found.append(self._seen(kind, camera, points, picture))
        projections = [camera.matrix for camera in self._cameras]
        arm, hand = (triangulate_many(projections, np.stack(found, axis=1)) for found in pixels.values())
        return np.vstack([arm[:1], hand[1:]])

    @torch.no_grad()
    def _seen(self, kind: CropKind, camera: CameraCalibration, points: Array, picture: Picture) -> Array:
        """The points (22, 2) in undistorted px."""
        at = camera.distort_pixels(project(camera.matrix, points))
        _, jacobian, _ = image_of(camera.matrix, points[WRIST])
        width_px = CROP_M[kind] * float(np.linalg.norm(jacobian, 2))
        middle = at[WRIST] if kind == "arm" else at[list(KNUCKLES)].mean(axis=0)
        crop = crop_about(middle, at[MIDDLE_KNUCKLE] - at[WRIST], width_px)
        rgb = torch.from_numpy(crop.cut(picture)[:, :, ::-1].copy()).permute(2, 0, 1)[None]
        _, found, _, _ = self._networks[kind](rgb.float() / 127.5 - 1.0)
        return camera.undistort_pixels(crop.in_picture(found[0, :, :2].double().numpy()))
