"""Where a bundle of boards begins: each camera by itself, then all in the first one's frame."""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration.boards import Board, BoardView
from local_site.calibration.bundle import BundleScene, Observations
from local_site.calibration.control_points import Size
from local_site.calibration.lens import Lens
from local_site.calibration.physical_camera import PhysicalCamera

MAX_DISAGREEMENT_RAD = 0.15
STRAIGHT = (
    cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_PRINCIPAL_POINT
)

UNSOLVABLE = "the pictures give no camera; show the board larger, flat and at more angles, and give its true squares"

Views = Sequence[Sequence[BoardView | None]]
Pose = tuple[Array, Array]


def observations(views: Views, board: Board) -> Observations:
    """All corners that the cameras saw, from each camera's view of each pose."""
    seen = [(k, i, v) for k, own in enumerate(views) for i, v in enumerate(own) if v is not None]
    return Observations(
        camera=np.concatenate([np.full(len(v.ids), k) for k, _, v in seen]),
        pose=np.concatenate([np.full(len(v.ids), i) for _, i, v in seen]),
        corners=np.concatenate([board.corners[v.ids] for _, _, v in seen]),
        pixels=np.concatenate([v.pixels for _, _, v in seen]),
    )


def starting_scene(views: Views, board: Board, sizes: Sequence[Size], names: Sequence[str]) -> BundleScene:
    """Cameras and poses to begin with, in the first camera's frame; every pose is seen by it and by another camera.

    Raises CalibrationError where two cameras disagree about how the board moved.
    """
    lenses, poses = zip(*(_alone(own, board, size) for own, size in zip(views, sizes, strict=True)), strict=True)
    cameras = [PhysicalCamera(lenses[0], np.eye(3), np.zeros(3))]
    for lens, own, name in zip(lenses[1:], poses[1:], names[1:], strict=True):
        common = [i for i in own if i in poses[0]]
        between = [_after(own[i], poses[0][i]) for i in common]
        rotation, translation = _middle(between, names[0], name)
        cameras.append(PhysicalCamera(lens, rotation, translation))
    places = [_place(i, poses, cameras) for i in range(len(views[0]))]
    return BundleScene(tuple(cameras), np.array([r for r, _ in places]), np.array([t for _, t in places]))


def _alone(views: Sequence[BoardView | None], board: Board, size: Size) -> tuple[Lens, dict[int, Pose]]:
    """One camera's lens, and the poses (camera_R_board, translation) of the boards that it saw."""
    seen = {i: view for i, view in enumerate(views) if view is not None}
    corners = [board.corners[view.ids].astype(np.float32) for view in seen.values()]
    pixels = [view.pixels.astype(np.float32) for view in seen.values()]
    guess, bending = np.eye(3), np.zeros(5)
    try:
        _, k, _, turns, shifts = cv2.calibrateCamera(corners, pixels, size, guess, bending, flags=STRAIGHT)
    except cv2.error as error:
        raise CalibrationError(f"{UNSOLVABLE} ({error.err})") from error
    lens = Lens(float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2]))
    poses = {
        i: (Rotation.from_rotvec(np.ravel(turn)).as_matrix(), np.ravel(shift).astype(np.float64))
        for i, turn, shift in zip(seen, turns, shifts, strict=True)
    }
    return lens, poses


def _after(second: Pose, first: Pose) -> Pose:
    """second_T_first of two cameras that see the same board."""
    rotation = second[0] @ first[0].T
    return rotation, second[1] - rotation @ first[1]


def _middle(between: Sequence[Pose], first: str, second: str) -> Pose:
    """The pose that most others agree with; CalibrationError if they do not agree at all."""
    turns = Rotation.from_matrix(np.array([rotation for rotation, _ in between]))
    apart = np.array([(turns[i].inv() * turns).magnitude() for i in range(len(between))])
    typical = np.median(apart, axis=1)
    best = int(np.argmin(typical))
    if typical[best] > MAX_DISAGREEMENT_RAD:
        raise CalibrationError(
            f"the {first} and the {second} camera do not agree how the board moved; give their pictures in the same "
            "order, taken at the same instants, and switch off the mirroring of both"
        )
    return between[best]


def _place(pose: int, poses: Sequence[dict[int, Pose]], cameras: Sequence[PhysicalCamera]) -> Pose:
    """A board in the first camera's frame, by the first camera that saw it."""
    for camera, own in zip(cameras, poses, strict=True):
        if pose in own:
            rotation, translation = own[pose]
            back = camera.camera_R_operator.T
            return back @ rotation, back @ (translation - camera.translation)
    raise CalibrationError(f"pose {pose + 1}: no camera saw the board; leave this picture out")
