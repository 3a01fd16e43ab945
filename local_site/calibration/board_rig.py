"""A rig from pictures of a printed board in several poses: lenses and poses of the cameras, and their errors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration import accuracy, checks
from local_site.calibration.accuracy import board_errors
from local_site.calibration.boards import Board
from local_site.calibration.bundle import (
    UNSOLVABLE,
    Adjusted,
    BundleScene,
    Observations,
    Views,
    adjust,
    observations,
    starting_scene,
)
from local_site.calibration.control_points import ControlPoints, Size
from local_site.calibration.physical_camera import ASPECT, BASE, K1, K2
from local_site.calibration.resection import choose_model, folds
from local_site.calibration.rig import Rig
from local_site.calibration.solve import make_rig

MIN_POSES = 5
MIN_TILT_DEG = 15.0
MAX_RMS_PX = 3.0


@dataclass(frozen=True, slots=True)
class BoardPictures:
    """Each camera's view of each pose (None where the board was not seen), and its picture's width and height in px."""

    views: Views
    sizes: tuple[Size, ...]
    names: tuple[str, ...]


def solve_boards(
    pictures: BoardPictures, board: Board, created: str, standing: bool = False
) -> tuple[Rig, ControlPoints]:
    """The rig of board pictures, and the corners seen, in the operator frame.

    The first pose that two cameras saw sets the operator frame: origin in the middle of the print, x along the edge of
    the print that runs to the right in the left camera's picture. If the board lies, z points out of the print and y
    away from the cameras; if it is upright, y points into the print and z up. Raises CalibrationError for too few or
    too similar poses, cameras that do not agree, and exchanged cameras.
    """
    views = _common_views(pictures.views)
    seen = observations(views, board)
    start = starting_scene(views, board, pictures.sizes, pictures.names)
    _refuse_similar_poses(start)
    fitted, why = _fit(start, seen)
    rms_px = [
        float(np.sqrt(np.mean(np.sum(fitted.residuals[seen.camera == k] ** 2, axis=1)))) for k in range(len(views))
    ]
    _refuse_misfit(rms_px, pictures.names)
    old_R_new, old_t_new = operator_pose(fitted.scene, board, standing)
    cameras = [camera.in_frame(old_R_new, old_t_new) for camera in fitted.scene.cameras]
    mistake = checks.same_view(cameras, np.zeros((1, 3))) or checks.exchanged(cameras)
    if mistake:
        raise CalibrationError(mistake)
    pixels = [_pixels(views, pose, len(board.corners)) for pose in range(len(views[0]))]
    control = _control(pictures, pixels, board, (fitted.scene, old_R_new, old_t_new))
    errors = _error_rms(pixels, board, fitted, seen, old_R_new)
    return make_rig(control, cameras, rms_px, errors, (why,) * len(cameras), created), control


def _common_views(views: Views) -> Views:
    """The poses that two cameras saw; CalibrationError if they are too few."""
    common = [i for i, pose in enumerate(zip(*views, strict=True)) if sum(view is not None for view in pose) >= 2]
    if len(common) < MIN_POSES:
        raise CalibrationError(
            f"the board was seen by two cameras in {len(common)} poses, needs at least {MIN_POSES}; show it at more "
            "positions and angles, whole, well lit and still"
        )
    return [[own[i] for i in common] for own in views]


def _refuse_similar_poses(scene: BundleScene) -> None:
    normals = scene.rotations[:, :, 2]
    tilt = float(np.degrees(np.arccos(np.clip(np.min(normals @ normals.T), -1.0, 1.0))))
    if tilt < MIN_TILT_DEG:
        raise CalibrationError(
            f"all poses of the board are within {tilt:.0f} degrees of each other; tilt it by {2 * MIN_TILT_DEG:.0f} "
            "degrees or more, about both of its edges, or focal length and distance cannot be separated"
        )


def _fit(start: BundleScene, seen: Observations) -> tuple[Adjusted, str]:
    def refit(chosen: Adjusted, free: tuple[int, ...]) -> Adjusted:
        return adjust(chosen.scene, seen, free)

    def unreal(chosen: Adjusted) -> bool:
        points = chosen.scene.points(seen)
        return any(folds(camera, points[seen.camera == k]) for k, camera in enumerate(chosen.scene.cameras))

    try:
        return choose_model(adjust(start, seen, (*BASE, ASPECT, K1, K2)), refit, unreal)
    except (ValueError, np.linalg.LinAlgError) as error:
        raise CalibrationError(f"{UNSOLVABLE} ({error})") from error


def _refuse_misfit(rms_px: Sequence[float], names: Sequence[str]) -> None:
    if max(rms_px) > MAX_RMS_PX:
        worst = [f"{name} {rms:.1f} px" for name, rms in zip(names, rms_px, strict=True)]
        raise CalibrationError(
            f"the pictures do not fit one rig (residuals: {', '.join(worst)}); keep cameras and board still while a "
            "picture is taken, keep the board flat, and give its true squares"
        )


def operator_pose(scene: BundleScene, board: Board, standing: bool) -> tuple[Array, Array]:
    """The operator frame in the first camera's frame, by the first board: old_R_new (3, 3), old_t_new (3,) in m."""
    right, down, into = scene.rotations[0].T
    x = max((right, -right, down, -down), key=lambda axis: float(axis[0]))
    z = np.cross(x, into) if standing else -into
    axes = np.column_stack([x, np.cross(z, x), z])
    return axes, scene.rotations[0] @ board.middle + scene.translations[0]


def _pixels(views: Views, pose: int, count: int) -> list[Array]:
    """Each camera's pixels (count, 2) of a pose's corners, NaN where unseen."""
    pixels = []
    for own in views:
        found, view = np.full((count, 2), np.nan), own[pose]
        if view is not None:
            found[view.ids] = view.pixels
        pixels.append(found)
    return pixels


def _control(
    pictures: BoardPictures, pixels: Sequence[list[Array]], board: Board, solved: tuple[BundleScene, Array, Array]
) -> ControlPoints:
    """The corners of all poses as points in the operator frame, with the pixels that were measured."""
    scene, old_R_new, old_t_new = solved
    points = np.einsum("pij,cj->pci", scene.rotations, board.corners) + scene.translations[:, None]
    measured = tuple(np.concatenate(of_camera) for of_camera in zip(*pixels, strict=True))
    seen = np.any([np.isfinite(own[:, 0]) for own in measured], axis=0)
    corners = range(len(board.corners))
    labels = np.array([f"pose {pose + 1}, corner {corner}" for pose in range(len(pixels)) for corner in corners])
    return ControlPoints(
        points=((points - old_t_new) @ old_R_new).reshape(-1, 3)[seen],
        pixels=tuple(own[seen] for own in measured),
        labels=tuple(labels[seen].tolist()),
        source="the board",
        sizes=pictures.sizes,
    )


def _error_rms(
    pixels: Sequence[list[Array]], board: Board, fitted: Adjusted, seen: Observations, old_R_new: Array
) -> tuple[Array | None, Array | None]:
    """3D error per axis of the operator frame (rms, m): by the rig, and by rigs made without each pose in turn."""
    all_in = board_errors([fitted.scene.cameras] * len(pixels), board.corners, pixels)
    left_out = board_errors([fitted.cameras_without(i, seen) for i in range(len(pixels))], board.corners, pixels)
    return accuracy.rms(all_in @ old_R_new), accuracy.rms(left_out @ old_R_new)
