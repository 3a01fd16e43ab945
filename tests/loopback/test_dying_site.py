"""A site that dies under the loopback: its last line states which process died, and why."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from farhand.loopback.site_process import options_of
from remote_site.session.config import ACCEPTANCE

LIGHT = ("--seconds", "6", "--headless", "--tracker", "markers")
ATTEMPTS = 3  # on a machine that is too slow for the arm to be followed
DRIVER = """
from farhand.driver import Capabilities

class Mute:
    capabilities = Capabilities(rate_hz=500.0, joints=6, gripper=False, force=False, watchdog_ms=None)

    def __init__(self, host):
        pass

    def configure(self, setup):
        raise ValueError("no arm answers at address 7")
"""
MORTAL = """
import os
from remote_site.drivers.kinematic import KinematicDriver

class Mortal(KinematicDriver):
    first = None

    def __init__(self, host):
        super().__init__(host.clock)

    def write(self, command):
        self.first = command.motion.q if self.first is None else self.first
        if abs(command.motion.q - self.first).max() > 0.1:
            os._exit(7)
        return super().write(command)
"""


def install(folder: Path, name: str, program: str, driver: str) -> None:
    """A package in the folder that offers a driver."""
    package = folder / f"{name}-1.dist-info"
    package.mkdir()
    (package / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
    (package / "entry_points.txt").write_text(f"[farhand.drivers]\n{name} = {name}_driver:{driver}\n")
    (folder / f"{name}_driver.py").write_text(program)


def loopback(folder: Path, *settings: str) -> subprocess.CompletedProcess[str]:
    """A loopback that finds a folder's packages, ended."""
    command = [sys.executable, "-m", "farhand", "loopback", *LIGHT, *options_of(settings)]
    return subprocess.run(
        command,
        check=False,
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])},
    )


def last_line(folder: Path, *settings: str) -> tuple[int, str]:
    """Exit code and last line of such a loopback."""
    done = loopback(folder, *settings)
    return done.returncode, done.stderr.splitlines()[-1]


@pytest.mark.slow
def test_a_driver_that_cannot_be_configured_is_named_with_its_reason(tmp_path: Path) -> None:
    install(tmp_path, "mute", DRIVER, "Mute")
    code, line = last_line(tmp_path, "driver.name=mute", f"engagement.automatic_accepted={ACCEPTANCE}")
    assert code == 1
    assert line.startswith("farhand: broken: the remote process ended (exit code 1): remote: process driver died")
    assert line.endswith("ValueError: no arm answers at address 7")


@pytest.mark.slow
def test_what_was_measured_is_printed_where_a_site_dies_after_the_arm_followed(tmp_path: Path) -> None:
    install(tmp_path, "mortal", MORTAL, "Mortal")
    for _ in range(ATTEMPTS):
        done = loopback(tmp_path, "driver.name=mortal", f"engagement.automatic_accepted={ACCEPTANCE}")
        assert done.returncode == 1
        if "exposure to joint command, ms" not in done.stdout:
            assert "this machine was too slow" in done.stderr
            continue
        died = "the remote process ended (exit code 1): remote: process driver died"
        *_, before, last = done.stderr.splitlines()
        if not last.startswith("this machine was too slow"):
            assert last.startswith(f"farhand: broken: {died}")
            return
        if before.startswith(f"farhand: {died}"):
            return
    pytest.fail(f"the machine was too slow for the arm to be followed till the driver died: {done.stderr}")


@pytest.mark.slow
def test_a_urdf_that_cannot_be_read_is_named_with_its_reason(tmp_path: Path) -> None:
    model = tmp_path / "arm.urdf"
    model.write_text("<robot")
    code, line = last_line(tmp_path, "driver.name=kinematic", f"robot.model={model}")
    assert code == 1
    assert line.startswith("farhand: broken: the remote process ended (exit code 2): ")
    assert f"cannot read the robot model {model}" in line
