"""Every example does what it shows, as a program of its own, and is short."""

import re
import subprocess
import sys
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from common.messages.robot import SessionState
from farhand.loopback.site_process import free_ports, listens
from tests.farhand.export.test_recording import recorded  # noqa: F401  # a fixture
from tests.integration.sites import CELL, Sites, running_sites

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
LONGEST = 60


@contextmanager
def started(name: str, *arguments: object) -> Iterator[subprocess.Popen[str]]:
    """An example, as a person starts it in a checkout; it is ended with the block."""
    command = [sys.executable, f"examples/{name}.py", *map(str, arguments)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def printed(name: str, *arguments: object) -> str:
    """What an example printed; it has to end well."""
    with started(name, *arguments) as process:
        out, error = process.communicate(timeout=90)
    assert process.returncode == 0, error
    return out


@pytest.fixture(scope="module")
def sites() -> Iterator[Sites]:
    """A remote site that a hand may move."""
    with running_sites() as running:
        running.remote("driver.name=kinematic", "video.cameras=[{name='side', source='simulated'}]")
        running.wait_for_states()
        yield running


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_it_is_short_and_in_the_list(path: Path) -> None:
    assert len(path.read_text().splitlines()) <= LONGEST
    assert f"| `{path.name}` |" in (ROOT / "examples/README.md").read_text()


def test_a_driver_passes_farhands_checks() -> None:
    lines = printed("driver").splitlines()
    assert len(lines) > 10


def test_a_tracker_finds_its_spot() -> None:
    off_mm = re.search(r"tracked off by ([\d.]+) mm", printed("tracker"))
    assert off_mm is not None
    assert float(off_mm[1]) < 2.0


def test_the_state_of_a_cell_is_read(sites: Sites) -> None:
    lines = printed("cell_state", sites.endpoints.control, CELL, 3).splitlines()
    assert len(lines) >= 2
    assert all(line.startswith("disengaged: ") and line.endswith(" rad") for line in lines)


def test_a_hand_out_of_a_file_moves_the_arm(sites: Sites, tmp_path: Path) -> None:
    poses = tmp_path / "poses.csv"
    poses.write_text("0,0.0,0.0,0.3\n8,0.0,0.0,0.3\n10,0.0,0.0,0.35\n14,0.0,0.0,0.35\n")
    with started("published_hand", poses, sites.endpoints.control, CELL) as hand:
        sites.wait("readiness", lambda: sites.state.readiness.ready)
        before = np.array(sites.state.base_T_tool.position)
        engage = [sys.executable, "-m", "farhand", "engage", "--cell", CELL, "--operator", "example", "--remote"]
        subprocess.run([*engage, sites.endpoints.control], check=True, capture_output=True, timeout=60)
        sites.wait("the arm to follow", lambda: sites.is_in(SessionState.ENGAGED))
        sites.wait(
            "the way", lambda: bool(abs(np.linalg.norm(sites.state.base_T_tool.position - before) - 0.05) < 0.005)
        )
        hand.communicate(timeout=60)
    assert hand.returncode == 0


def test_a_page_shows_a_view(sites: Sites) -> None:
    (port,) = free_ports(1)
    with started("own_page", "side", port, sites.endpoints.video, CELL):
        sites.wait("the page", lambda: listens(port))
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=30) as film:
            data = film.read(20_000)
    assert data.startswith(b"--picture\r\nContent-Type: image/jpeg\r\n\r\n\xff\xd8\xff")
    assert data.count(b"\xff\xd8\xff") >= 2


def test_a_recording_becomes_arrays(recorded: Path, tmp_path: Path) -> None:  # noqa: F811
    assert " instants of " in printed("recording_in_numpy", recorded, tmp_path / "run.npz")
    with np.load(tmp_path / "run.npz") as arrays:
        assert arrays["joints"].shape == arrays["sent"].shape == (len(arrays["t_s"]), 6)
        assert arrays["t_s"][-1] > 2.0
        assert np.ptp(arrays["tool"][1:, :3], axis=0).max() > 0.01
