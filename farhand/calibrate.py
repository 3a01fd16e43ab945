"""Calibration from files: control points in, rig file out."""

import math
from datetime import UTC, datetime
from pathlib import Path

from local_site.calibration.control_points import read_control_points
from local_site.calibration.dlt import solve_rig
from local_site.calibration.rig import Rig, save_rig


def calibrate_points(csv: Path, out: Path) -> Rig:
    """Solve the rig of a control point file and write it; CalibrationError names every mistake of the file."""
    rig = solve_rig(read_control_points(csv), created=datetime.now(UTC).isoformat(timespec="seconds"))
    save_rig(rig, out)
    return rig


def describe_rig(rig: Rig, out: Path) -> str:
    """What a person wants to know of a new rig: reprojection per camera and 3D error per axis."""
    cameras = ", ".join(f"{camera.name} {camera.reprojection_rms_px:.3f} px" for camera in rig.cameras)
    x, y, z = (1e3 * error for error in rig.error_rms)
    total = math.sqrt(x * x + y * y + z * z)
    return (
        f"reprojection rms: {cameras}\n"
        f"3D error rms: X {x:.3f} mm, Y {y:.3f} mm, Z {z:.3f} mm, total {total:.3f} mm\n"
        f"rig written to {out}"
    )
