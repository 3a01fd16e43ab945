"""What cannot be right in a rig: read from a file, it may have been cut, edited, or made by something else."""

from collections.abc import Iterator

import numpy as np

from common.geometry import Array
from local_site.calibration import checks
from local_site.calibration.control_points import CAMERAS
from local_site.calibration.physical_camera import PhysicalCamera, decomposed
from local_site.calibration.rig import CameraCalibration, Rig

MAX_SKEW = 0.05
MAX_ASPECT = 1.4
MAX_BENDING = 2.0
MIN_DETERMINANT = 1e-12
ASIDE = 1.0  # how far beside the picture, in widths and heights of it, the middle of the volume may lie


def rig_mistakes(rig: Rig) -> list[str]:
    """Everything that cannot be right in a rig, a sentence each; empty if all is well."""
    names = tuple(camera.name for camera in rig.cameras)
    expected = CAMERAS[: len(names)]
    if len(names) < 2 or names != expected:
        told = ", ".join(names) or "none"
        return [f"its cameras are {told}, but must be left, right and, if there are more, third, fourth, in this order"]
    if any(low >= high for low, high in zip(rig.volume_min, rig.volume_max, strict=True)):
        return ["the box of its control points, volume_min to volume_max, has no size"]
    middle = (np.array(rig.volume_min) + np.array(rig.volume_max)) / 2
    mistakes = [f"{camera.name} camera: {what}" for camera in rig.cameras for what in _camera_mistakes(camera, middle)]
    if mistakes:
        return mistakes
    cameras = [camera for one in rig.cameras if (camera := decomposed(_facing(one.matrix, middle))) is not None]
    return [what for what in (checks.same_view(cameras, middle[None]) or checks.exchanged(cameras),) if what]


def _camera_mistakes(calibrated: CameraCalibration, middle: Array) -> Iterator[str]:
    """What is wrong with one camera, given the middle (3,) of the volume, m."""
    matrix = _facing(calibrated.matrix, middle)
    if abs(float(np.linalg.det(matrix[:, :3]))) < MIN_DETERMINANT:
        yield "its projection is singular"
        return
    camera = decomposed(matrix)
    if camera is None:
        yield "its projection is mirrored, or looks away from the volume"
        return
    if not _is_a_cameras(matrix, camera):
        yield "its projection is no camera's: its pixels are not nearly square"
    width, height = calibrated.size_px or (2 * camera.lens.cx, 2 * camera.lens.cy)
    pixel = camera.pixels(middle)
    if not np.all(np.abs(pixel / (width, height) - 0.5) <= 0.5 + ASIDE):
        yield "it does not see the middle of the volume"
    lens = calibrated.lens
    if lens is not None:
        inner = height / 4
        bent = float(lens.distort_pixels(np.array([lens.cx + inner, lens.cy]))[0] - lens.cx) / inner
        if not 1 / MAX_BENDING < bent < MAX_BENDING:
            yield "its lens bends the picture beyond sense"


def _facing(matrix: Array, middle: Array) -> Array:
    """The projection (3, 4) with the sign that gives the middle of the volume a positive depth."""
    depth = float(matrix[2, :3] @ middle + matrix[2, 3])
    return -matrix if depth < 0 else matrix


def _is_a_cameras(matrix: Array, camera: PhysicalCamera) -> bool:
    """Whether the projection is nearly that of square pixels in rows and columns."""
    lens = camera.lens
    calibration = matrix[:, :3] @ camera.camera_R_operator.T
    skew = float(calibration[0, 1] / calibration[0, 0])
    return abs(skew) < MAX_SKEW and 1 / MAX_ASPECT < lens.fx / lens.fy < MAX_ASPECT
