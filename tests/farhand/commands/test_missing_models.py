"""Without the models of the tracker `learned` every command that tracks ends with the command that gets them."""

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from farhand.exits import MISUSE
from farhand.loopback.site_process import free_ports
from local_site.calibration.rig_file import save_rig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig


def track_arguments(folder: Path) -> list[str]:
    """A track of one pair of dark pictures."""
    save_rig(exact_rig(SimulationConfig().stereo), folder / "rig.json")
    for name in ("left", "right"):
        (folder / name).mkdir()
        cv2.imwrite(str(folder / name / "0.png"), np.full((480, 640, 3), len(name), np.uint8))
    given = ["track", "--rig", "rig.json", "--left", "left", "--right", "right", "--fps", "30"]
    return [*given, "--tracker", "learned"]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["loopback", "local", "track"])
def test_a_command_that_tracks_ends_with_the_cure(command: str, tmp_path: Path) -> None:
    (port,) = free_ports(1)
    arguments = {
        "loopback": ["loopback", "--headless", "--tracker", "learned"],
        "local": ["local", "--set", "tracking.method=learned", "--set", f"links.listen=tcp/127.0.0.1:{port}"],
        "track": track_arguments(tmp_path),
    }
    environment = {name: value for name, value in os.environ.items() if name != "CACHE_DIRECTORY"}
    done = subprocess.run(
        [sys.executable, "-m", "farhand", *arguments[command]],
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
        cwd=tmp_path,
        env=environment | {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == MISUSE, done.stderr
    assert "run 'farhand models install'" in done.stderr
    assert "Traceback" not in done.stderr
