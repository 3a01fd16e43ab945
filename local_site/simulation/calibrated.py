"""Calibrates the simulated operator's cameras as real ones are: from control points with pixel noise."""

import tempfile
from pathlib import Path

from local_site.calibration.control_points import read_control_points
from local_site.calibration.rig import Rig
from local_site.calibration.solve import solve_rig
from local_site.simulation.cameras import control_point_rows
from local_site.simulation.config import SimulationConfig

CONTROL_POINT_NOISE_PX = 0.3


def calibrate_simulated(config: SimulationConfig) -> Rig:
    """The rig of a simulated stereo pair, solved from the 75 points of a simulated plate."""
    rows = control_point_rows(config.stereo, CONTROL_POINT_NOISE_PX, config.seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "control_points.csv"
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
        return solve_rig(read_control_points(path), created="simulated")
