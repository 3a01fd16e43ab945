"""The rig: a projection matrix and a lens for each camera in the operator frame."""

from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from common.geometry import Array
from local_site.calibration.physical_camera import Lens

Row4 = tuple[float, float, float, float]
Projection = tuple[Row4, Row4, Row4]
Vector3 = tuple[float, float, float]
Pixels = Annotated[int, Meta(ge=1)]

VOLUME_MARGIN = 0.15


class CameraCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One camera: 3 x 4 projection from metres in the operator frame to undistorted pixels, its lens, its residual at
    calibration. Without a `lens` the picture is not distorted."""

    name: str
    projection: Projection
    reprojection_rms_px: Annotated[float, Meta(ge=0)]
    lens: Lens | None = None
    serial: str = ""
    size_px: tuple[Pixels, Pixels] | None = None

    @property
    def matrix(self) -> Array:
        """The projection as an array (3, 4)."""
        return np.array(self.projection)

    def undistort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) for which the projection holds, of pixels (..., 2) in the camera's picture."""
        return pixels if self.lens is None else self.lens.undistort_pixels(pixels)

    def distort_pixels(self, pixels: Array) -> Array:
        """Pixels (..., 2) in the camera's picture, of pixels (..., 2) for which the projection holds."""
        return pixels if self.lens is None else self.lens.distort_pixels(pixels)


class Rig(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The calibrated cameras, the bounding box of the control points (m), and the calibration's errors.

    `error_rms` is the 3D error per axis (rms, m) of the points that made the rig, `leave_one_out_rms` of each point by
    a rig made without it; `epipolar_px` the median epipolar residual of the points; `lens_choice` why each lens has the
    distortion terms it has.
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

    def contains(self, point: Array) -> bool:
        """Return whether a point (3,) in m lies in the control points' box, extended by VOLUME_MARGIN of its sides."""
        sides = zip(point.tolist(), self.volume_min, self.volume_max, strict=True)
        margin = VOLUME_MARGIN
        return all(low - margin * (high - low) < x < high + margin * (high - low) for x, low, high in sides)
