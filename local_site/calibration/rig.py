"""The rig: a projection matrix and a lens for each camera in the operator frame."""

from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from common.geometry import Array
from local_site.calibration.lens import Lens

Row4 = tuple[float, float, float, float]
Vector3 = tuple[float, float, float]
Pixels = Annotated[int, Meta(ge=1)]


class CameraCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One camera: 3 x 4 projection from metres in the operator frame to pixels, its lens, its residual at calibration.

    `projection` is a pure pinhole's. With a `lens` it holds for undistorted pixels only (`lens.undistort_pixels`);
    without one it holds for the picture as it is.
    """

    name: str
    projection: tuple[Row4, Row4, Row4]
    reprojection_rms_px: Annotated[float, Meta(ge=0)]
    lens: Lens | None = None
    serial: str = ""
    size_px: tuple[Pixels, Pixels] | None = None

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
    epipolar_px: Annotated[float, Meta(ge=0)] | None = None
    lens_choice: tuple[str, ...] = ()

    @property
    def matrices(self) -> tuple[Array, ...]:
        """The projections in camera order."""
        return tuple(camera.matrix for camera in self.cameras)
