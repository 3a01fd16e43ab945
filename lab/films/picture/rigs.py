"""The rigs that film: two to four cameras about the volume, exactly calibrated."""

from dataclasses import dataclass
from typing import Literal

from msgspec import convert

from local_site.calibration.physical_camera import PhysicalCamera
from local_site.calibration.rig import CameraCalibration, Projection, Rig
from local_site.simulation.cameras import looking_at_centre
from local_site.simulation.config import StereoConfig

RigName = Literal["standard", "close", "wide", "high", "distorted", "four"]
Size = tuple[int, int]

STANDARD_WIDTH_PX = 640
VOLUME_MIN, VOLUME_MAX = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
NAMES = ("left", "right", "third", "fourth")


@dataclass(frozen=True, slots=True)
class Placing:
    """The place of a camera: its turn off the middle and its height as angles in degrees, its distance in m from the
    centre, its focal length in px for a picture 640 px wide, its distortion."""

    turn_deg: float
    rise_deg: float = 15.0
    distance_m: float = 1.5
    focal_px: float = 800.0
    k1: float = 0.0


PLACINGS: dict[RigName, tuple[Placing, ...]] = {
    "standard": (Placing(-25.0), Placing(25.0)),
    "close": (Placing(-20.0, 20.0, 0.9, 560.0), Placing(22.0, 18.0, 0.95, 560.0)),
    "wide": (Placing(-46.0, 10.0, 1.4, 700.0), Placing(30.0, 22.0, 1.6, 760.0)),
    "high": (Placing(-22.0, 45.0, 1.3, 640.0), Placing(24.0, 32.0, 1.3, 640.0)),
    "distorted": (Placing(-25.0, 15.0, 1.2, 620.0, -0.1), Placing(25.0, 18.0, 1.2, 620.0, -0.1)),
    "four": (Placing(-25.0), Placing(25.0), Placing(-8.0, 40.0), Placing(-48.0, 20.0)),
}


def film_cameras(name: RigName, size: Size) -> tuple[PhysicalCamera, ...]:
    """The cameras of a rig with pictures of this size (width, height) in px."""
    return tuple(_camera(placing, size) for placing in PLACINGS[name])


def film_rig(cameras: tuple[PhysicalCamera, ...], size: Size) -> Rig:
    """The rig of these cameras, without any error."""
    calibrations = tuple(
        CameraCalibration(
            name,
            convert(camera.projection.tolist(), Projection),
            reprojection_rms_px=0.0,
            lens=camera.lens if camera.lens.is_distorted else None,
            size_px=size,
        )
        for name, camera in zip(NAMES, cameras, strict=False)
    )
    return Rig(calibrations, VOLUME_MIN, VOLUME_MAX, error_rms=(0.0, 0.0, 0.0), created="exact, filmed")


def _camera(placing: Placing, size: Size) -> PhysicalCamera:
    config = StereoConfig(
        width_px=size[0],
        height_px=size[1],
        focal_px=placing.focal_px * size[0] / STANDARD_WIDTH_PX,
        distance_m=placing.distance_m,
        elevation_deg=placing.rise_deg,
        k1=placing.k1,
    )
    return looking_at_centre(config, placing.turn_deg).physical
