"""Looks at the machine: facts for the checks that concern no site."""

import importlib.metadata
import os
import re
import shutil
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

import local_site
from common.errors import CameraError
from farhand.doctor.machine import (
    LEAST_PRIORITY,
    CacheFacts,
    CongestionFacts,
    PythonFacts,
    RealTimeFacts,
    RoomFacts,
)

REQUIREMENT_NAME = re.compile(r"[A-Za-z0-9._-]+")
TCP = Path("/proc/sys/net/ipv4")
STATE = Path("/var/lib/farhand")
SERVICE_CACHE = Path("/var/cache/farhand/numba")
SHARED_MEMORY = Path("/dev/shm")  # noqa: S108  # looked at, not written to
VIEW_PX = (64, 48)


def probe_python() -> PythonFacts:
    """The interpreter, and the libraries that this installation asks for."""
    wanted = [line for line in importlib.metadata.requires("farhand") or () if "extra ==" not in line]
    names = [found[0] for line in wanted if (found := REQUIREMENT_NAME.match(line))]
    version = sys.version_info
    return PythonFacts((version.major, version.minor, version.micro), tuple(filter(_is_missing, names)))


def _is_missing(name: str) -> bool:
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return True
    return False


def probe_rendering() -> str | None:
    """What stands in the way of drawing off screen; None when it works."""
    try:
        import mujoco  # noqa: PLC0415  # an installation for a real cell may be without it

        from remote_site.video.cell_cameras import OffScreen  # noqa: PLC0415  # the same
    except ImportError as error:
        return f"simulated views need MuJoCo ({error})"
    try:
        OffScreen(mujoco.MjModel.from_xml_string("<mujoco/>"), *VIEW_PX).close()
    except CameraError as error:
        return str(error)
    return None


def probe_real_time() -> RealTimeFacts:
    """The limit, and what the scheduler says to a thread that asks and ends."""
    import resource  # noqa: PLC0415  # there is none where there is no RLIMIT_RTPRIO

    granted: list[bool] = []
    thread = threading.Thread(target=lambda: granted.append(_ask_for_real_time()))
    thread.start()
    thread.join()
    return RealTimeFacts(resource.getrlimit(resource.RLIMIT_RTPRIO)[0], granted == [True])


def _ask_for_real_time() -> bool:
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LEAST_PRIORITY))
    except PermissionError:
        return False
    return True


def probe_congestion() -> CongestionFacts:
    """What the kernel uses for TCP, and could use."""
    active, available = _words(TCP / "tcp_congestion_control"), _words(TCP / "tcp_available_congestion_control")
    return CongestionFacts(" ".join(active), tuple(available))


def _words(path: Path) -> Sequence[str]:
    return path.read_text().split() if path.exists() else ()


def probe_disk() -> RoomFacts:
    """Room where the service keeps its state, or where we stand."""
    return _room(STATE if STATE.is_dir() else Path.cwd())


def probe_shared_memory() -> RoomFacts:
    """Room for what processes share."""
    return _room(SHARED_MEMORY)


def _room(place: Path) -> RoomFacts:
    try:
        return RoomFacts(str(place), shutil.disk_usage(place).free)
    except OSError:
        return RoomFacts(str(place), None)


def probe_cache() -> CacheFacts:
    """Where numba will look for compiled code: in the service's folder, beside the package, or in the user's cache."""
    beside = Path(local_site.__file__).parent / "tracking/silhouette/__pycache__"
    users = beside if _is_writable(beside) else Path.home() / ".cache/numba"
    place = Path(os.environ.get("NUMBA_CACHE_DIR") or (SERVICE_CACHE if SERVICE_CACHE.is_dir() else users))
    return CacheFacts(str(place), _is_writable(place), sum(1 for _ in place.rglob("*.nbi")))


def _is_writable(place: Path) -> bool:
    """Whether a folder can be written, or made."""
    while not place.exists():
        place = place.parent
    return os.access(place, os.W_OK)
