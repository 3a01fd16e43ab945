"""The thesis's calibration plate and a printed board before simulated cameras, and rigs calibrated from them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from common.cameras.camera import Image
from common.geometry import Array
from lab.experiments.report import Progress
from local_site.calibration.accuracy import align_rigidly
from local_site.calibration.board_rig import BoardPictures, solve_boards
from local_site.calibration.boards import Board, BoardFinder
from local_site.calibration.control_points import CAMERAS, ControlPoints
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.plate import Plate, plate_control_points, view_plate, without_perspective_bias
from local_site.calibration.resection import solve_projection
from local_site.calibration.rig import Rig
from local_site.calibration.solve import solve_rig
from local_site.calibration.triangulation import triangulate_many
from local_site.simulation.calibration_scenes.board_scene import SIZE, BoardRenderer
from local_site.simulation.calibration_scenes.plate_scene import plate_picture
from local_site.simulation.cameras import PLATE_HEIGHTS_M, stereo_pair
from local_site.simulation.config import StereoConfig

PLATE = Plate()
BOARD = Board("chessboard", 9, 6, 0.06)  # as large as these cameras need to find its corners from 3 m
CREATED = "simulated"
MEASURING_SEED, POSE_SEED = 11, 3


@dataclass(frozen=True, slots=True)
class PlateScene:
    """Two cameras before the plate at its heights: their pictures, by camera and height, and the discs found there.

    `centred` are the same discs without the bias of their perspective, as `farhand calibrate` sees them.
    """

    cameras: tuple[PhysicalCamera, ...]
    pictures: tuple[tuple[Image, ...], ...]
    found: ControlPoints
    centred: ControlPoints


def filming_cameras(k1: float) -> tuple[PhysicalCamera, ...]:
    """Two cameras that see the whole volume, through lenses of this radial distortion."""
    sees_all = StereoConfig(distance_m=3.0, elevation_deg=40.0, centre=(0.5, 0.5, 0.45), k1=k1)
    return tuple(camera.physical for camera in stereo_pair(sees_all))


def film_plate(k1: float, progress: Progress) -> PlateScene:
    """Render the plate at three heights and find its discs."""
    cv2.setNumThreads(1)
    cameras, pictures = filming_cameras(k1), []
    for c, camera in enumerate(cameras):
        own = []
        for k, height in enumerate(PLATE_HEIGHTS_M):
            own.append(plate_picture(PLATE, camera, height, seed=len(PLATE_HEIGHTS_M) * c + k))
            progress()
        pictures.append(tuple(own))
    views = [
        [view_plate(picture, PLATE, name) for picture in own] for name, own in zip(CAMERAS, pictures, strict=False)
    ]
    found = plate_control_points(views, PLATE_HEIGHTS_M, PLATE)
    centred = without_perspective_bias(found, solve_rig(found, CREATED).matrices, PLATE.diameter)
    return PlateScene(cameras, tuple(pictures), found, centred)


def every(control: ControlPoints, step: int) -> ControlPoints:
    """One of every `step` control points, from the first on."""
    pixels = tuple(own[::step] for own in control.pixels)
    return replace(control, points=control.points[::step], pixels=pixels, labels=control.labels[::step])


def measured_to(control: ControlPoints, sigma_mm: float) -> ControlPoints:
    """The control points as somebody has measured them: with a normal error along each axis."""
    errors = np.random.default_rng(MEASURING_SEED).standard_normal(control.points.shape)
    return replace(control, points=control.points + 1e-3 * sigma_mm * errors)


def dlt_points(calibrating: ControlPoints, seen: ControlPoints) -> Array:
    """Points (N, 3) in m of the discs seen, by the direct linear transformation of other discs, without a lens."""
    projections = [_dlt(calibrating.points, pixels) for pixels in calibrating.pixels]
    return triangulate_many(projections, np.stack(seen.pixels, axis=1))


def _dlt(points: Array, pixels: Array) -> Array:
    known = np.isfinite(pixels[:, 0])
    return solve_projection(points[known], pixels[known])


def rig_points(rig: Rig, seen: ControlPoints) -> Array:
    """Points (N, 3) in m of the discs seen, by a rig and its lenses."""
    straight = [camera.undistort_pixels(own) for camera, own in zip(rig.cameras, seen.pixels, strict=True)]
    return triangulate_many(rig.matrices, np.stack(straight, axis=1))


def board_rig(cameras: Sequence[PhysicalCamera], poses: int, progress: Progress) -> Rig:
    """The rig of a printed board that is held up at places all over the volume."""
    finder = BoardFinder(BOARD)
    renderers = [BoardRenderer(BOARD, camera, seed) for seed, camera in enumerate(cameras)]
    views = []
    for pose in _board_poses(poses):
        views.append([finder.find(renderer.picture(*pose)) for renderer in renderers])
        progress()
    by_camera = [list(own) for own in zip(*views, strict=True)]
    return solve_boards(BoardPictures(by_camera, (SIZE,) * len(cameras), CAMERAS[: len(cameras)]), BOARD, CREATED)[0]


def _board_poses(count: int) -> list[tuple[Array, Array]]:
    """Poses (operator_R_board, translation in m), tilted towards the cameras more or less."""
    random, flat = np.random.default_rng(POSE_SEED), np.diag([1.0, -1.0, -1.0])
    found = []
    for _ in range(count):
        tilt = Rotation.from_euler("xyz", random.uniform((10, -30, -25), (60, 30, 25)), degrees=True).as_matrix()
        middle = random.uniform((0.2, 0.2, 0.2), (0.8, 0.8, 0.8))
        found.append((tilt @ flat, middle - tilt @ flat @ BOARD.middle))
    return found


def aligned(points: Array, known: Array) -> Array:
    """Points (N, 3) moved by the rigid motion that fits them best to known ones: a board sets a frame of its own."""
    moved, seen = np.full(points.shape, np.nan), np.isfinite(points[:, 0])
    moved[seen] = align_rigidly(points[seen], known[seen])
    return moved
