"""Calibration from files: control points in, rig file out."""

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
