"""What the machine must offer: pure judgements of probed facts."""

from collections.abc import Sequence

from farhand.doctor.findings import Finding, error, ok, warning

LEAST_PYTHON = (3, 11)
LEAST_PRIORITY = 50
LITTLE_DISK_BYTES, LEAST_DISK_BYTES = 2_000_000_000, 200_000_000
LITTLE_SHARED_BYTES = 64_000_000
MEGA = 1_000_000


def check_python(version: tuple[int, int, int], missing: Sequence[str]) -> Finding:
    """The interpreter's version; `missing` are those of Farhand's libraries that are not installed."""
    text = ".".join(map(str, version))
    if version[:2] < LEAST_PYTHON:
        return error("python", f"{text} is too old", "install Python 3.11 or newer, then run deploy/install.sh again")
    if missing:
        return error("python", f"not installed: {', '.join(missing)}", "run deploy/install.sh again")
    return ok("python", f"{text}, all libraries are installed")


def check_rendering(problem: str | None) -> Finding:
    """Whether simulated views can be rendered; `problem` is the error of EGL."""
    if problem is None:
        return ok("rendering", "EGL renders off screen")
    cure = "apt-get install libegl1 libopengl0 libgl1-mesa-dri, or give video.cameras real sources"
    return error("rendering", problem, cure)


def check_real_time(limit: int, granted: bool) -> Finding:
    """SCHED_FIFO for control and tracking: RLIMIT_RTPRIO, and whether the scheduler granted LEAST_PRIORITY."""
    if granted:
        return ok("real time", f"SCHED_FIFO up to priority {LEAST_PRIORITY} is granted to this user")
    cure = (
        "the services get it from LimitRTPRIO; to run by hand, write 'NAME - rtprio 50' to a file in "
        "/etc/security/limits.d/ and log in again"
    )
    return warning("real time", f"SCHED_FIFO is refused (RLIMIT_RTPRIO is {limit}): control ticks will be late", cure)


def check_congestion(active: str, available: Sequence[str]) -> Finding:
    """The kernel's congestion control in use, and those available: BBR keeps queues short on a link full of video."""
    if active == "bbr":
        return ok("congestion", "BBR is in use")
    load = "" if "bbr" in available else "modprobe tcp_bbr; echo tcp_bbr > /etc/modules-load.d/bbr.conf; "
    cure = f"{load}echo net.ipv4.tcp_congestion_control=bbr > /etc/sysctl.d/60-bbr.conf; sysctl --system"
    return warning("congestion", f"{active or 'unknown'} is in use: video may delay all else on its link", cure)


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


def check_cache(folder: str, writable: bool, compiled: int) -> Finding:
    """The tracker's compiled code: its folder, and how many functions are in it."""
    if not writable and not compiled:
        cure = f"let this user write to {folder}, or set NUMBA_CACHE_DIR"
        return warning("compiled code", f"{folder} is not writable: every start takes up to a minute", cure)
    if not compiled:
        cure = "none is needed; to compile now: python -m local_site.runtime.warm_up"
        return warning("compiled code", f"none yet in {folder}: the first start takes up to a minute", cure)
    return ok("compiled code", f"{compiled} functions in {folder}")
