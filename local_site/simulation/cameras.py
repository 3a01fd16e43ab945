"""The simulated stereo pair: exact projections, optional radial distortion, control points, calibration by these."""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from msgspec import convert

from common.geometry import Array
from local_site.calibration.control_points import read_control_points
from local_site.calibration.physical_camera import Lens, PhysicalCamera
from local_site.calibration.rig import CameraCalibration, Projection, Rig
from local_site.calibration.solve import solve_rig
from local_site.simulation.config import SimulationConfig, StereoConfig

NAMES = ("left", "right")
PLATE_SIZE_M = 1.0
PLATE_HEIGHTS_M = (0.0, 0.497, 0.994)
PLATE_POINTS = 5
CONTROL_POINT_NOISE_PX = 0.3


@dataclass(frozen=True, slots=True)
class PinholeCamera:
    """One camera: `camera_R_operator` (3, 3) and centre (3,) in m, focal length and principal point in px, k1."""

    camera_R_operator: Array
    centre: Array
    focal_px: float
    principal_px: Array
    k1: float

    @property
    def physical(self) -> PhysicalCamera:
        """The same camera as a calibration would find it."""
        u, v = self.principal_px.tolist()
        lens = Lens(self.focal_px, self.focal_px, u, v, self.k1)
        return PhysicalCamera(lens, self.camera_R_operator, -self.camera_R_operator @ self.centre)

    @property
    def projection(self) -> Array:
        """The 3 x 4 matrix from metres in the operator frame to undistorted pixels."""
        return self.physical.projection

    def to_camera(self, points: Array) -> Array:
        """Points (..., 3) in the operator frame, in the camera's: x right, y down, z away, m."""
        return (points - self.centre) @ self.camera_R_operator.T

    def pixels(self, in_camera: Array) -> Array:
        """Pixels (..., 2) of points (..., 3) in the camera's frame, distorted as the lens does."""
        slopes = in_camera[..., :2] / in_camera[..., 2:]
        if self.k1:
            slopes = slopes * (1.0 + self.k1 * np.sum(slopes * slopes, axis=-1, keepdims=True))
        return self.focal_px * slopes + self.principal_px


def stereo_pair(config: StereoConfig) -> tuple[PinholeCamera, PinholeCamera]:
    """The left and the right camera, both looking at the volume's centre."""
    left, right = (looking_at_centre(config, sign * config.half_angle_deg) for sign in (-1.0, 1.0))
    return left, right


def looking_at_centre(config: StereoConfig, turn_deg: float) -> PinholeCamera:
    """A camera that looks at the volume's centre, turned off the middle."""
    turn, rise = math.radians(turn_deg), math.radians(config.elevation_deg)
    away = np.array([-math.sin(turn) * math.cos(rise), math.cos(turn) * math.cos(rise), -math.sin(rise)])
    right = np.array([math.cos(turn), math.sin(turn), 0.0])
    return PinholeCamera(
        camera_R_operator=np.vstack([right, np.cross(away, right), away]),
        centre=np.array(config.centre) - config.distance_m * away,
        focal_px=config.focal_px,
        principal_px=np.array([(config.width_px - 1) / 2, (config.height_px - 1) / 2]),
        k1=config.k1,
    )


def exact_rig(config: StereoConfig) -> Rig:
    """The rig of the undistorted pair, without any error; what a calibration is to find."""
    cameras = tuple(
        CameraCalibration(name, convert(camera.projection.tolist(), Projection), reprojection_rms_px=0.0)
        for name, camera in zip(NAMES, stereo_pair(config), strict=True)
    )
    return Rig(
        cameras=cameras,
        volume_min=(0.0, 0.0, PLATE_HEIGHTS_M[0]),
        volume_max=(PLATE_SIZE_M, PLATE_SIZE_M, PLATE_HEIGHTS_M[-1]),
        error_rms=(0.0, 0.0, 0.0),
        created="exact, simulated",
    )


def control_points() -> Array:
    """The 75 points (75, 3), m, of a plate of 25 at three heights (thesis section 3.2.9.1)."""
    ticks = np.linspace(0.0, PLATE_SIZE_M, PLATE_POINTS)
    return np.array([(x, y, z) for z in PLATE_HEIGHTS_M for y in ticks for x in ticks])


def control_point_rows(config: StereoConfig, noise_px: float, seed: int) -> list[str]:
    """The control points as both cameras see them, as lines of CSV with their header; empty where out of view."""
    points = control_points()
    random = np.random.default_rng(seed)
    columns = [[f"{1000 * value:.3f}" for value in point] for point in points]
    for camera in stereo_pair(config):
        pixels = camera.pixels(camera.to_camera(points)) + noise_px * random.standard_normal((len(points), 2))
        for column, (u, v) in zip(columns, pixels.tolist(), strict=True):
            seen = 0 <= u <= config.width_px - 1 and 0 <= v <= config.height_px - 1
            column.extend((f"{u:.3f}", f"{v:.3f}") if seen else ("", ""))
    return ["X_mm,Y_mm,Z_mm,uL_px,vL_px,uR_px,vR_px", *(",".join(column) for column in columns)]


def calibrate_simulated(config: SimulationConfig) -> Rig:
    """The rig of a simulated stereo pair, calibrated as real ones are: from the 75 points of a plate, with noise."""
    rows = control_point_rows(config.stereo, CONTROL_POINT_NOISE_PX, config.seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "control_points.csv"
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
        return solve_rig(read_control_points(path), created="simulated")
