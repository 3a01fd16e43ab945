"""What systemd hears of a daemon: ready once, the watchdog fed while the loop comes round, the end announced."""

import os
import signal
import socket
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from sites import Sites, running_sites

from farhand.loopback import free_ports

PATIENCE_S = 60.0
FIGURES = {"farhand_control_missed_ticks_total", "farhand_session_state", "farhand_video_frames_total"}


class Systemd:
    """The socket that a daemon notifies; every message as it comes."""

    def __init__(self, path: Path) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._socket.settimeout(PATIENCE_S)

    def hear(self) -> str:
        """The next message; TimeoutError when none comes."""
        return self._socket.recv(256).decode()

    def close(self) -> None:
        self._socket.close()


@pytest.fixture
def systemd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Systemd]:
    systemd = Systemd(tmp_path / "notify")
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    yield systemd
    systemd.close()


@pytest.fixture
def sites(systemd: Systemd) -> Iterator[Sites]:  # noqa: ARG001  # the socket must be there before any site
    with running_sites() as sites:
        yield sites


@pytest.mark.parametrize("site", ["remote", "local"])
def test_a_daemon_tells_systemd_of_its_life(site: str, sites: Sites, systemd: Systemd) -> None:
    process = sites.remote("driver.name=kinematic") if site == "remote" else sites.local()
    assert systemd.hear() == "READY=1"
    assert [systemd.hear() for _ in range(5)] == ["WATCHDOG=1"] * 5
    os.kill(process.pid, signal.SIGTERM)
    words = [systemd.hear()]
    while words[-1] == "WATCHDOG=1":
        words.append(systemd.hear())
    assert words[-1] == "STOPPING=1"
    sites.wait("the daemon to end", lambda: process.exit_code == 0, 5)


def test_a_child_that_stands_still_ends_the_remote_site_so_that_systemd_starts_it_again(
    sites: Sites, systemd: Systemd
) -> None:
    process = sites.remote("driver.name=kinematic")
    assert systemd.hear() == "READY=1"
    video = next(child for child in children_of(process.pid) if name_of(child) == "farhand-video")
    os.kill(video, signal.SIGSTOP)
    try:
        sites.wait("the remote site to end", lambda: process.exit_code is not None, 12)
    finally:
        if Path(f"/proc/{video}").exists():
            os.kill(video, signal.SIGCONT)
    assert process.exit_code == 1
    assert "process video hangs" in process.last_error()


def test_figures_are_served_and_the_site_goes_on_when_they_die(sites: Sites) -> None:
    (port,) = free_ports(1)
    process = sites.remote("driver.name=kinematic", f"metrics.port={port}")
    sites.wait("figures of control and video", lambda: figures_at(port) >= FIGURES, 20)
    metrics = next(child for child in children_of(process.pid) if name_of(child) == "farhand-metrics")
    os.kill(metrics, signal.SIGKILL)
    sites.wait("the site to say so", lambda: any("goes on without it" in line for line in process.lines), 5)
    told = len(sites.record.states)
    sites.wait("control to go on", lambda: len(sites.record.states) > told + 50, 10)
    assert process.exit_code is None


def figures_at(port: int) -> set[str]:
    """The names of the figures that are served now; none while nobody serves."""
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=5) as answer:
            page = answer.read().decode()
    except OSError:
        return set()
    return {line.partition("{")[0].partition(" ")[0] for line in page.splitlines() if not line.startswith("#")}


def children_of(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def name_of(pid: int) -> str:
    return Path(f"/proc/{pid}/comm").read_text().strip()
