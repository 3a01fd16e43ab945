"""Requirements of the machine and its installation: each fact is probed, then judged by a pure check."""

import importlib.metadata
import os
import re
import shutil
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import local_site
from common.errors import CameraError, ModelError
from farhand.doctor.findings import Finding, error, ok, warning
from local_site.tracking.eye.networks import EyeNetworks

LEAST_PYTHON = (3, 11)
LEAST_PRIORITY = 50
LITTLE_DISK_BYTES, LEAST_DISK_BYTES = 2_000_000_000, 200_000_000
LITTLE_SHARED_BYTES = 64_000_000
MEGA = 1_000_000
REQUIREMENT_NAME = re.compile(r"[A-Za-z0-9._-]+")
TCP = Path("/proc/sys/net/ipv4")
STATE = Path("/var/lib/farhand")
SERVICE_CACHE = Path("/var/cache/farhand/numba")
SHARED_MEMORY = Path("/dev/shm")  # noqa: S108  # only its free space is read
VIEW_PX = (64, 48)


def probe_python() -> tuple[tuple[int, int, int], list[str]]:
    """The interpreter's version, and those libraries that this installation requires but lacks."""
    required = [line for line in importlib.metadata.requires("farhand") or () if "extra ==" not in line]
    missing = []
    for found in filter(None, map(REQUIREMENT_NAME.match, required)):
        try:
            importlib.metadata.version(found[0])
        except importlib.metadata.PackageNotFoundError:
            missing.append(found[0])
    return sys.version_info[:3], missing


def check_python(version: tuple[int, int, int], missing: Sequence[str]) -> Finding:
    """The interpreter's version; `missing` are those of Farhand's libraries that are not installed."""
    text = ".".join(map(str, version))
    if version[:2] < LEAST_PYTHON:
        return error("python", f"{text} is too old", "install Python 3.11 or newer, then run deploy/install.sh again")
    if missing:
        return error("python", f"not installed: {', '.join(missing)}", "run deploy/install.sh again")
    return ok("python", f"{text}, all libraries are installed")


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


def check_rendering(problem: str | None) -> Finding:
    """Check that simulated views can be rendered; `problem` is the error of EGL."""
    if problem is None:
        return ok("rendering", "EGL renders off screen")
    cure = "apt-get install libegl1 libopengl0 libgl1-mesa-dri, or give video.cameras real sources"
    return error("rendering", problem, cure)


def probe_real_time() -> tuple[int, bool]:
    """RLIMIT_RTPRIO, and whether the scheduler grants SCHED_FIFO to a thread that asks for it and ends."""
    import resource  # noqa: PLC0415  # there is none where there is no RLIMIT_RTPRIO

    granted = []

    def ask() -> None:
        with suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(LEAST_PRIORITY))
            granted.append(True)

    thread = threading.Thread(target=ask)
    thread.start()
    thread.join()
    return resource.getrlimit(resource.RLIMIT_RTPRIO)[0], bool(granted)


def check_real_time(limit: int, granted: bool) -> Finding:
    """SCHED_FIFO for control and tracking: RLIMIT_RTPRIO, and whether the scheduler granted LEAST_PRIORITY."""
    if granted:
        return ok("real time", f"SCHED_FIFO up to priority {LEAST_PRIORITY} is granted to this user")
    cure = (
        "the services get it from LimitRTPRIO; to run by hand, write 'NAME - rtprio 50' to a file in "
        "/etc/security/limits.d/ and log in again"
    )
    return warning("real time", f"SCHED_FIFO is refused (RLIMIT_RTPRIO is {limit}): control ticks will be late", cure)


def probe_congestion() -> tuple[str, list[str]]:
    """The kernel's congestion control for TCP in use, and those available."""
    paths = TCP / "tcp_congestion_control", TCP / "tcp_available_congestion_control"
    active, available = (path.read_text().split() if path.exists() else [] for path in paths)
    return " ".join(active), available


def check_congestion(active: str, available: Sequence[str]) -> Finding:
    """The kernel's congestion control in use, and those available: BBR keeps queues short on a link full of video."""
    if active == "bbr":
        return ok("congestion", "BBR is in use")
    load = "" if "bbr" in available else "modprobe tcp_bbr; echo tcp_bbr > /etc/modules-load.d/bbr.conf; "
    cure = f"{load}echo net.ipv4.tcp_congestion_control=bbr > /etc/sysctl.d/60-bbr.conf; sysctl --system"
    return warning("congestion", f"{active or 'unknown'} is in use: video may delay all else on its link", cure)


def probe_free_bytes(folder: Path) -> tuple[str, int | None]:
    """A folder and the free bytes there; None where they cannot be read."""
    try:
        return str(folder), shutil.disk_usage(folder).free
    except OSError:
        return str(folder), None


def check_disk(folder: str, free_bytes: int | None) -> Finding:
    """Space for logs, compiled code and recordings; None where it could not be read."""
    if free_bytes is None:
        return warning("disk", f"the free space of {folder} cannot be read", "run the doctor as a user who may read it")
    sentence = f"{free_bytes // MEGA} MB free in {folder}"
    if free_bytes < LEAST_DISK_BYTES:
        return error("disk", sentence, "free disk space")
    if free_bytes < LITTLE_DISK_BYTES:
        return warning("disk", sentence, "free disk space before you record anything")
    return ok("disk", sentence)


def check_shared_memory(folder: str, free_bytes: int | None) -> Finding:
    """Space for the pictures that processes of one host exchange; None where there is no shared memory."""
    if free_bytes is None:
        return error("shared memory", f"{folder} is not mounted", f"mount -t tmpfs tmpfs {folder}")
    sentence = f"{free_bytes // MEGA} MB free in {folder}"
    if free_bytes < LITTLE_SHARED_BYTES:
        cure = f"mount -o remount,size=256M {folder}; in a container: --shm-size=256m"
        return warning("shared memory", sentence, cure)
    return ok("shared memory", sentence)


def probe_cache() -> tuple[str, bool, int]:
    """Find where numba will look for compiled code, whether that is writable, and how many functions are there.

    That is the service's folder, beside the package, or in the user's cache.
    """
    beside = Path(local_site.__file__).parent / "tracking/silhouette/__pycache__"
    users = beside if _is_writable(beside) else Path.home() / ".cache/numba"
    folder = Path(os.environ.get("NUMBA_CACHE_DIR") or (SERVICE_CACHE if SERVICE_CACHE.is_dir() else users))
    return str(folder), _is_writable(folder), sum(1 for _ in folder.rglob("*.nbi"))


def _is_writable(folder: Path) -> bool:
    """Return whether a folder can be written, or made."""
    while not folder.exists():
        folder = folder.parent
    return os.access(folder, os.W_OK)


def check_cache(folder: str, writable: bool, compiled: int) -> Finding:
    """The tracker's compiled code: its folder, and how many functions are in it."""
    if not writable and not compiled:
        cure = f"let this user write to {folder}, or set NUMBA_CACHE_DIR"
        return warning("compiled code", f"{folder} is not writable: every start takes up to a minute", cure)
    if not compiled:
        cure = "none is needed; to compile now: python -m local_site.runtime.warm_up"
        return warning("compiled code", f"none yet in {folder}: the first start takes up to a minute", cure)
    return ok("compiled code", f"{compiled} functions in {folder}")


def probe_networks() -> str:
    """Say why the networks of the tracker `eye` cannot be run; empty if they can."""
    try:
        EyeNetworks()
    except ModelError as wrong:
        return str(wrong)
    return ""


def check_networks(wrong: str) -> Finding:
    """The networks of the tracker `eye`; `wrong` is why they cannot be run."""
    if wrong:
        return error("networks of the tracker", wrong, "pip install --force-reinstall --no-deps farhand")
    return ok("networks of the tracker", "can be run")
