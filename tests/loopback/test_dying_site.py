"""A site that dies under the loopback: its last line states which process died, and why."""

import os
import subprocess
import sys
from pathlib import Path

from remote_site.session.config import ACCEPTANCE

LIGHT = ("--seconds", "3", "--headless", "--tracker", "markers")
DRIVER = """
from farhand.driver import Capabilities

class Mute:
    capabilities = Capabilities(rate_hz=500.0, joints=6, gripper=False, force=False, watchdog_ms=None)

    def __init__(self, host):
        pass

    def configure(self, setup):
        raise ValueError("no arm answers at address 7")
"""


def last_line(folder: Path, *settings: str) -> tuple[int, str]:
    """Exit code and last line of a loopback that finds a folder's packages."""
    command = [sys.executable, "-m", "farhand", "loopback", *LIGHT]
    command += [part for setting in settings for part in ("--set", setting)]
    done = subprocess.run(
        command,
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])},
    )
    return done.returncode, done.stderr.splitlines()[-1]


def test_a_driver_that_cannot_be_configured_is_named_with_its_reason(tmp_path: Path) -> None:
    package = tmp_path / "mute-1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: mute\nVersion: 1\n")
    (package / "entry_points.txt").write_text("[farhand.drivers]\nmute = mute_driver:Mute\n")
    (tmp_path / "mute_driver.py").write_text(DRIVER)
    code, line = last_line(tmp_path, "driver.name=mute", f"engagement.automatic_accepted={ACCEPTANCE}")
    assert code == 1
    assert line.startswith("farhand: the remote process ended (exit code 1): remote: process driver died")
    assert line.endswith("ValueError: no arm answers at address 7")


def test_a_urdf_that_cannot_be_read_is_named_with_its_reason(tmp_path: Path) -> None:
    model = tmp_path / "arm.urdf"
    model.write_text("<robot")
    code, line = last_line(tmp_path, "driver.name=kinematic", f"robot.model={model}")
    assert code == 1
    assert line.startswith("farhand: the remote process ended (exit code 2): ")
    assert f"cannot read the robot model {model}" in line
