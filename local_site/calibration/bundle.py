"""Bundle: cameras and board poses together, with the least squared reprojection error over all pictures."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from common.geometry import Array
from local_site.calibration.physical_camera import BASE, NUMBERS, PhysicalCamera
from local_site.calibration.resection import scattered

POSE_NUMBERS = 6
POSE_OF_CAMERA = BASE[3:]
SLOPE_STEP = 1e-6
TOLERANCE = 1e-10
MAX_STEPS = 60


@dataclass(frozen=True, slots=True)
class Observations:
    """M corners: which camera (M,) saw which board pose (M,), the corner (M, 3) on the board in m, its pixel (M, 2)."""

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

    def places(self, seen: Observations) -> Array:
        """The observed corners (M, 3) in the cameras' common frame, m."""
        turned = np.einsum("mij,mj->mi", self.rotations[seen.pose], seen.corners)
        result: Array = turned + self.translations[seen.pose]
        return result

    def residuals(self, seen: Observations) -> Array:
        """Model less measured pixels (M, 2)."""
        points = self.places(seen)
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


@dataclass(frozen=True, slots=True)
class Adjusted:
    """An adjusted scene, the camera numbers that were free, residuals (M, 2) and their slope (2M, all numbers)."""

    scene: BundleScene
    free: tuple[int, ...]
    residuals: Array
    slope: Array

    @property
    def numbers(self) -> int:
        """How many numbers were fitted."""
        return int(self.slope.shape[1])

    def cameras_without(self, pose: int, seen: Observations) -> tuple[PhysicalCamera, ...]:
        """The cameras that the other poses alone would give, to first order."""
        rest = np.repeat(seen.pose != pose, 2)
        scale = 1.0 / np.maximum(np.linalg.norm(self.slope, axis=0), 1e-300)
        rows = self.slope[rest] * scale
        step = -scale * np.linalg.lstsq(rows, self.residuals.ravel()[rest], rcond=1e-12)[0]
        steps, _ = _split(step, self.free, len(self.scene.cameras), len(self.scene.rotations))
        return tuple(camera.stepped(own) for camera, own in zip(self.scene.cameras, steps, strict=True))


def adjust(start: BundleScene, seen: Observations, free: tuple[int, ...]) -> Adjusted:
    """The scene with the least squared residuals; `free` are the numbers to fit; the first camera stays in place."""
    simple = BundleScene(tuple(c.simplified(free) for c in start.cameras), start.rotations, start.translations)
    cameras, poses = len(simple.cameras), len(simple.rotations)

    def at(numbers: Array) -> BundleScene:
        return simple.stepped(*_split(numbers, free, cameras, poses))

    def residuals(numbers: Array) -> Array:
        return at(numbers).residuals(seen).ravel()

    def slope(numbers: Array) -> Array:
        return _slope(simple, numbers, free, seen)

    zero = np.zeros(cameras * len(free) - len(POSE_OF_CAMERA) + POSE_NUMBERS * poses)
    fit = least_squares(
        residuals,
        zero,
        slope,
        method="lm",
        x_scale="jac",
        ftol=TOLERANCE,
        xtol=TOLERANCE,
        gtol=TOLERANCE,
        max_nfev=MAX_STEPS,
    )
    scene = at(fit.x)
    return Adjusted(scene, free, scene.residuals(seen), slope(fit.x))


def _split(numbers: Array, free: tuple[int, ...], cameras: int, poses: int) -> tuple[Array, Array]:
    """Steps of cameras (cameras, NUMBERS) and poses (poses, 6) from all free numbers."""
    first = tuple(n for n in free if n not in POSE_OF_CAMERA)
    ends = np.cumsum([len(first), *[len(free)] * (cameras - 1)])
    own = np.split(numbers, ends)
    steps = [scattered(own[0], first), *(scattered(part, free) for part in own[1:cameras])]
    return np.array(steps), own[cameras].reshape(poses, POSE_NUMBERS)


def _slope(simple: BundleScene, numbers: Array, free: tuple[int, ...], seen: Observations) -> Array:
    """Slope (2M, all numbers): each corner hangs on one camera and one pose, so that one step serves all of them."""
    cameras, poses = len(simple.cameras), len(simple.rotations)
    camera_steps, pose_steps = _split(numbers, free, cameras, poses)
    columns = np.zeros((len(seen.pose), 2, len(numbers)))
    rows = np.arange(len(seen.pose))
    camera_place = _camera_places(free, cameras)
    for number in free:

        def camera_moved(by: float, number: int = number) -> Array:
            return simple.stepped(camera_steps + by * np.eye(NUMBERS)[number], pose_steps).residuals(seen)

        place = camera_place[seen.camera, number]
        known = place >= 0
        columns[rows[known], :, place[known]] = _difference(camera_moved)[known]
    for number in range(POSE_NUMBERS):

        def pose_moved(by: float, number: int = number) -> Array:
            return simple.stepped(camera_steps, pose_steps + by * np.eye(POSE_NUMBERS)[number]).residuals(seen)

        place = len(numbers) - POSE_NUMBERS * (poses - seen.pose) + number
        columns[rows, :, place] = _difference(pose_moved)
    return columns.reshape(-1, len(numbers))


def _camera_places(free: tuple[int, ...], cameras: int) -> NDArray[np.int64]:
    """Where each camera's numbers (cameras, NUMBERS) stand among all; -1 for those that are not fitted."""
    places = np.full((cameras, NUMBERS), -1, dtype=np.int64)
    count = 0
    for camera in range(cameras):
        for number in free:
            if camera > 0 or number not in POSE_OF_CAMERA:
                places[camera, number] = count
                count += 1
    return places


def _difference(moved: Callable[[float], Array]) -> Array:
    result: Array = (moved(SLOPE_STEP) - moved(-SLOPE_STEP)) / (2 * SLOPE_STEP)
    return result
