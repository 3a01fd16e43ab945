"""Bundle adjustment of cameras and board poses, and its initial scene from each camera by itself."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration.boards import Board, BoardView
from local_site.calibration.control_points import Size
from local_site.calibration.physical_camera import BASE, NUMBERS, Lens, PhysicalCamera
from local_site.calibration.resection import ModelFit, scattered

POSE_NUMBERS = 6
POSE_OF_CAMERA = BASE[3:]
JACOBIAN_STEP = 1e-6
TOLERANCE = 1e-10
MAX_STEPS = 60
MAX_DISAGREEMENT_RAD = 0.15
PINHOLE = (
    cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3 | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_PRINCIPAL_POINT
)

UNSOLVABLE = "the pictures give no camera; show the board larger, flat and at more angles, and give its true squares"

Views = Sequence[Sequence[BoardView | None]]
Pose = tuple[Array, Array]


@dataclass(frozen=True, slots=True)
class Observations:
    """M corners: the camera (M,), the board pose (M,), the corner (M, 3) on the board in m, its pixel (M, 2)."""

    camera: NDArray[np.int64]
    pose: NDArray[np.int64]
    corners: Array
    pixels: Array


@dataclass(frozen=True, slots=True)
class BundleScene:
    """The cameras, and the pose of each of P boards: `rotations` (P, 3, 3) and `translations` (P, 3) in m."""

    cameras: tuple[PhysicalCamera, ...]
    rotations: Array
    translations: Array

    def points(self, seen: Observations) -> Array:
        """The observed corners (M, 3) in the cameras' common frame, m."""
        turned = np.einsum("mij,mj->mi", self.rotations[seen.pose], seen.corners)
        result: Array = turned + self.translations[seen.pose]
        return result

    def residuals(self, seen: Observations) -> Array:
        """Model less measured pixels (M, 2)."""
        points = self.points(seen)
        found = np.empty_like(seen.pixels)
        for k, camera in enumerate(self.cameras):
            mine = seen.camera == k
            found[mine] = camera.pixels(points[mine])
        return found - seen.pixels

    def stepped(self, camera_steps: Array, pose_steps: Array) -> "BundleScene":
        """The scene a step away: (cameras, NUMBERS) and (P, 6), a rotation vector (rad) and a translation (m) each."""
        turns = Rotation.from_rotvec(pose_steps[:, :3]).as_matrix()
        return BundleScene(
            tuple(camera.stepped(step) for camera, step in zip(self.cameras, camera_steps, strict=True)),
            turns @ self.rotations,
            self.translations + pose_steps[:, 3:],
        )


@dataclass(frozen=True)
class Adjusted(ModelFit):
    """An adjusted scene; residuals are (M, 2), the Jacobian is (2M, all numbers)."""

    scene: BundleScene

    def cameras_without(self, pose: int, seen: Observations) -> tuple[PhysicalCamera, ...]:
        """The cameras that the other poses alone would give, to first order."""
        rest = np.repeat(seen.pose != pose, 2)
        scale = 1.0 / np.maximum(np.linalg.norm(self.jacobian, axis=0), 1e-300)
        rows = self.jacobian[rest] * scale
        step = -scale * np.linalg.lstsq(rows, self.residuals.ravel()[rest], rcond=1e-12)[0]
        steps, _ = _split(step, self.free, len(self.scene.cameras), len(self.scene.rotations))
        return tuple(camera.stepped(own) for camera, own in zip(self.scene.cameras, steps, strict=True))


def adjust(start: BundleScene, seen: Observations, free: tuple[int, ...]) -> Adjusted:
    """The scene with the least squared residuals; `free` are the numbers to fit; the first camera's pose is fixed."""
    simple = BundleScene(tuple(c.simplified(free) for c in start.cameras), start.rotations, start.translations)
    cameras, poses = len(simple.cameras), len(simple.rotations)

    def at(numbers: Array) -> BundleScene:
        return simple.stepped(*_split(numbers, free, cameras, poses))

    def residuals(numbers: Array) -> Array:
        return at(numbers).residuals(seen).ravel()

    def jacobian(numbers: Array) -> Array:
        return _jacobian(simple, numbers, free, seen)

    zero = np.zeros(cameras * len(free) - len(POSE_OF_CAMERA) + POSE_NUMBERS * poses)
    fit = least_squares(
        residuals,
        zero,
        jacobian,
        method="lm",
        x_scale="jac",
        ftol=TOLERANCE,
        xtol=TOLERANCE,
        gtol=TOLERANCE,
        max_nfev=MAX_STEPS,
    )
    scene = at(fit.x)
    return Adjusted(free, scene.residuals(seen), jacobian(fit.x), scene)


def _split(numbers: Array, free: tuple[int, ...], cameras: int, poses: int) -> tuple[Array, Array]:
    """Steps of cameras (cameras, NUMBERS) and poses (poses, 6) from all free numbers."""
    first = tuple(n for n in free if n not in POSE_OF_CAMERA)
    ends = np.cumsum([len(first), *[len(free)] * (cameras - 1)])
    own = np.split(numbers, ends)
    steps = [scattered(own[0], first), *(scattered(part, free) for part in own[1:cameras])]
    return np.array(steps), own[cameras].reshape(poses, POSE_NUMBERS)


def _jacobian(simple: BundleScene, numbers: Array, free: tuple[int, ...], seen: Observations) -> Array:
    """Jacobian (2M, all numbers): a corner depends on one camera and one pose, so that one step serves all of them."""
    sizes = free, len(simple.cameras), len(simple.rotations)
    camera_steps, pose_steps = _split(numbers, *sizes)
    # The column of each number, -1 for those that are not fitted.
    camera_columns, pose_columns = (
        of.astype(np.int64) - 1 for of in _split(np.arange(1.0, len(numbers) + 1.0), *sizes)
    )
    jacobian, rows = np.zeros((len(seen.pose), 2, len(numbers))), np.arange(len(seen.pose))

    def fill(columns: NDArray[np.int64], ahead: BundleScene, behind: BundleScene) -> None:
        fitted = columns >= 0
        difference = (ahead.residuals(seen) - behind.residuals(seen)) / (2 * JACOBIAN_STEP)
        jacobian[rows[fitted], :, columns[fitted]] = difference[fitted]

    for number in free:
        step = JACOBIAN_STEP * np.eye(NUMBERS)[number]
        moved = (simple.stepped(camera_steps + by, pose_steps) for by in (step, -step))
        fill(camera_columns[seen.camera, number], *moved)
    for number in range(POSE_NUMBERS):
        step = JACOBIAN_STEP * np.eye(POSE_NUMBERS)[number]
        moved = (simple.stepped(camera_steps, pose_steps + by) for by in (step, -step))
        fill(pose_columns[seen.pose, number], *moved)
    return jacobian.reshape(-1, len(numbers))


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
    """Initial cameras and poses in the first camera's frame; every pose is seen by it and by another camera.

    Raises CalibrationError if two cameras disagree about the board's motion.
    """
    lenses, poses = zip(*(_alone(own, board, size) for own, size in zip(views, sizes, strict=True)), strict=True)
    cameras = [PhysicalCamera(lenses[0], np.eye(3), np.zeros(3))]
    for lens, own, name in zip(lenses[1:], poses[1:], names[1:], strict=True):
        common = [i for i in own if i in poses[0]]
        between = [_after(own[i], poses[0][i]) for i in common]
        rotation, translation = _middle(between, names[0], name)
        cameras.append(PhysicalCamera(lens, rotation, translation))
    rotations, translations = zip(*(_board_pose(i, poses, cameras) for i in range(len(views[0]))), strict=True)
    return BundleScene(tuple(cameras), np.array(rotations), np.array(translations))


def _alone(views: Sequence[BoardView | None], board: Board, size: Size) -> tuple[Lens, dict[int, Pose]]:
    """One camera's lens, and the poses (camera_R_board, translation) of the boards that it saw."""
    seen = {i: view for i, view in enumerate(views) if view is not None}
    corners = [board.corners[view.ids].astype(np.float32) for view in seen.values()]
    pixels = [view.pixels.astype(np.float32) for view in seen.values()]
    try:
        _, k, _, turns, shifts = cv2.calibrateCamera(corners, pixels, size, np.eye(3), np.zeros(5), flags=PINHOLE)
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
    """The pose with the least median angle to the others; CalibrationError if even that is large."""
    turns = Rotation.from_matrix(np.array([rotation for rotation, _ in between]))
    apart = np.array([(turns[i].inv() * turns).magnitude() for i in range(len(between))])
    typical = np.median(apart, axis=1)
    best = int(np.argmin(typical))
    if typical[best] > MAX_DISAGREEMENT_RAD:
        raise CalibrationError(
            f"the {first} and the {second} camera disagree about the board's motion; give their pictures in the same "
            "order, taken at the same instants, and switch off the mirroring of both"
        )
    return between[best]


def _board_pose(pose: int, poses: Sequence[dict[int, Pose]], cameras: Sequence[PhysicalCamera]) -> Pose:
    """A board in the first camera's frame, by the first camera that saw it."""
    for camera, own in zip(cameras, poses, strict=True):
        if pose in own:
            rotation, translation = own[pose]
            back = camera.camera_R_operator.T
            return back @ rotation, back @ (translation - camera.translation)
    raise CalibrationError(f"pose {pose + 1}: no camera saw the board; leave this picture out")
