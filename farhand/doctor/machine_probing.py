"""Probes the machine: facts for the checks that concern no site."""

import importlib.metadata
import os
import re
import shutil
import sys
import threading
from pathlib import Path

import local_site
from common.errors import CameraError
from farhand.doctor.machine import LEAST_PRIORITY

REQUIREMENT_NAME = re.compile(r"[A-Za-z0-9._-]+")
TCP = Path("/proc/sys/net/ipv4")
STATE = Path("/var/lib/farhand")
SERVICE_CACHE = Path("/var/cache/farhand/numba")
SHARED_MEMORY = Path("/dev/shm")  # noqa: S108  # only its free space is read
VIEW_PX = (64, 48)


def probe_python() -> tuple[tuple[int, int, int], list[str]]:
    """The interpreter's version, and those libraries that this installation requires but lacks."""
    required = [line for line in importlib.metadata.requires("farhand") or () if "extra ==" not in line]
    names = [found[0] for line in required if (found := REQUIREMENT_NAME.match(line))]
    return sys.version_info[:3], list(filter(_is_missing, names))


def _is_missing(name: str) -> bool:
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return True
    return False


def probe_rendering() -> str | None:
    """Why nothing can be rendered off screen; None when it works."""
    try:
        import mujoco  # noqa: PLC0415  # an installation for a real cell may not have it

        from remote_site.video.cell_cameras import OffScreen  # noqa: PLC0415  # the same
    except ImportError as error:
        return f"simulated views need MuJoCo ({error})"
    try:
        OffScreen(mujoco.MjModel.from_xml_string("<mujoco/>"), *VIEW_PX).close()
    except CameraError as error:
        return str(error)
    return None


def probe_real_time() -> tuple[int, bool]:
    """RLIMIT_RTPRIO, and whether the scheduler grants SCHED_FIFO to a thread that asks for it and ends."""
    import resource  # noqa: PLC0415  # there is none where there is no RLIMIT_RTPRIO

    granted: list[bool] = []
    thread = threading.Thread(target=lambda: granted.append(_ask_for_real_time()))
    thread.start()
    thread.join()
    return resource.getrlimit(resource.RLIMIT_RTPRIO)[0], granted == [True]


def _ask_for_real_time() -> bool:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LEAST_PRIORITY))
    except PermissionError:
        return False
    return True


def probe_congestion() -> tuple[str, list[str]]:
    """The kernel's congestion control for TCP in use, and those available."""
    return " ".join(_words(TCP / "tcp_congestion_control")), _words(TCP / "tcp_available_congestion_control")


def _words(path: Path) -> list[str]:
    return path.read_text().split() if path.exists() else []


def probe_disk() -> tuple[str, int | None]:
    """The folder where the service keeps its state, else the working folder, and its free bytes."""
    return _free_bytes(STATE if STATE.is_dir() else Path.cwd())


def probe_shared_memory() -> tuple[str, int | None]:
    """The folder of shared memory, and its free bytes."""
    return _free_bytes(SHARED_MEMORY)


def _free_bytes(folder: Path) -> tuple[str, int | None]:
    try:
        return str(folder), shutil.disk_usage(folder).free
    except OSError:
        return str(folder), None


def probe_cache() -> tuple[str, bool, int]:
    """Where numba will look for compiled code, whether that is writable, and how many functions are there.

    That is the service's folder, beside the package, or in the user's cache.
    """
    beside = Path(local_site.__file__).parent / "tracking/silhouette/__pycache__"
    users = beside if _is_writable(beside) else Path.home() / ".cache/numba"
    folder = Path(os.environ.get("NUMBA_CACHE_DIR") or (SERVICE_CACHE if SERVICE_CACHE.is_dir() else users))
    return str(folder), _is_writable(folder), sum(1 for _ in folder.rglob("*.nbi"))


def _is_writable(folder: Path) -> bool:
    """Whether a folder can be written, or made."""
    while not folder.exists():
        folder = folder.parent
    return os.access(folder, os.W_OK)
