"""The rig: a projection matrix and a lens for each camera in the operator frame, kept in a JSON file."""

import math
from pathlib import Path

import msgspec
import numpy as np

from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration.lens import Lens

Row4 = tuple[float, float, float, float]
Vector3 = tuple[float, float, float]


class CameraCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One camera: 3 x 4 projection from metres in the operator frame to pixels, its lens, its residual at calibration.

    `projection` is a pure pinhole's. With a `lens` it holds for undistorted pixels only (`lens.undistort_pixels`);
    without one it holds for the picture as it is.
    """

    name: str
    projection: tuple[Row4, Row4, Row4]
    reprojection_rms_px: float
    lens: Lens | None = None
    serial: str = ""
    size_px: tuple[int, int] | None = None

    @property
    def matrix(self) -> Array:
        """The projection as an array (3, 4)."""
        return np.array(self.projection)


class Rig(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The calibrated cameras, the box that the control points span (m), and how well they give their places back.

    `error_rms` is the 3D error per axis (rms, m) of the points that made the rig, `leave_one_out_rms` of each point by
    a rig made without it; `epipolar_px` the median epipolar residual of the points; `lens_choice` why each lens was
    taken as bent or straight.
    """

    cameras: tuple[CameraCalibration, ...]
    volume_min: Vector3
    volume_max: Vector3
    error_rms: Vector3
    created: str
    leave_one_out_rms: Vector3 | None = None
    epipolar_px: float | None = None
    lens_choice: tuple[str, ...] = ()

    @property
    def matrices(self) -> tuple[Array, ...]:
        """The projections in camera order."""
        return tuple(camera.matrix for camera in self.cameras)


def load_rig(path: Path) -> Rig:
    """Read a rig file; CalibrationError names what is wrong and the cure."""
    cure = "make a rig with: farhand calibrate points CSV --out rig.json"
    try:
        rig = msgspec.json.decode(path.read_bytes(), type=Rig)
    except OSError as error:
        raise CalibrationError(f"cannot read the rig {path}: {error.strerror}; {cure}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise CalibrationError(f"{path} is not a rig file: {error}; {cure}") from error
    numbers = [v for camera in rig.cameras for row in camera.projection for v in row]
    if len(rig.cameras) < 2 or not all(map(math.isfinite, numbers)):
        raise CalibrationError(f"{path} needs at least two cameras with finite projections; {cure}")
    if any(abs(np.linalg.det(matrix[:, :3])) < 1e-12 for matrix in rig.matrices):
        raise CalibrationError(f"{path} holds a singular projection; {cure}")
    return rig


def save_rig(rig: Rig, path: Path) -> None:
    """Write a rig file, readable by a person."""
    try:
        path.write_bytes(msgspec.json.format(msgspec.json.encode(rig), indent=2) + b"\n")
    except OSError as error:
        raise CalibrationError(f"cannot write the rig {path}: {error.strerror}; choose another place") from error
