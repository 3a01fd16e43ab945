"""What the machine must offer: pure judgements over probed facts."""

from dataclasses import dataclass

from farhand.doctor.findings import Finding, error, ok, warning

LEAST_PYTHON = (3, 11)
LEAST_PRIORITY = 50
LITTLE_DISK_BYTES, LEAST_DISK_BYTES = 2_000_000_000, 200_000_000
LITTLE_SHARED_BYTES = 64_000_000
MEGA = 1_000_000


@dataclass(frozen=True, slots=True)
class PythonFacts:
    """The interpreter's version, and which of Farhand's libraries are not installed."""

    version: tuple[int, int, int]
    missing: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RealTimeFacts:
    """The highest SCHED_FIFO priority that the limit allows, and whether the scheduler really took it."""

    limit: int
    granted: bool


@dataclass(frozen=True, slots=True)
class CongestionFacts:
    """The kernel's congestion control in use, and those it could use at once."""

    active: str
    available: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class RoomFacts:
    """Free bytes at a place that is written to; None where it cannot be told."""

    place: str
    free_bytes: int | None


@dataclass(frozen=True, slots=True)
class CacheFacts:
    """Where the tracker's compiled code is kept, whether that can be written, and how many pieces there are."""

    place: str
    writable: bool
    compiled: int


def check_python(facts: PythonFacts) -> Finding:
    """The version and the libraries."""
    version = ".".join(map(str, facts.version))
    if facts.version[:2] < LEAST_PYTHON:
        return error("python", f"this is {version}", "install Python 3.11 or newer, then run deploy/install.sh again")
    if facts.missing:
        return error("python", f"not installed: {', '.join(facts.missing)}", "run deploy/install.sh again")
    return ok("python", f"{version}, all libraries are there")


def check_rendering(problem: str | None) -> Finding:
    """Whether simulated views can be drawn; `problem` is what EGL said."""
    if problem is None:
        return ok("rendering", "EGL draws off screen")
    cure = "apt-get install libegl1 libopengl0 libgl1-mesa-dri, or give video.cameras real sources"
    return error("rendering", problem, cure)


def check_real_time(facts: RealTimeFacts) -> Finding:
    """SCHED_FIFO for control and tracking."""
    if facts.granted:
        return ok("real time", f"SCHED_FIFO up to priority {LEAST_PRIORITY} is granted to this user")
    cure = (
        "the services have it by LimitRTPRIO; to run by hand, write 'NAME - rtprio 50' to /etc/security/limits.d/, "
        "log in again"
    )
    return warning("real time", f"SCHED_FIFO is refused (RLIMIT_RTPRIO is {facts.limit}): ticks come late", cure)


def check_congestion(facts: CongestionFacts) -> Finding:
    """BBR keeps queues short on a link that video fills."""
    if facts.active == "bbr":
        return ok("congestion", "BBR is in use")
    load = "" if "bbr" in facts.available else "modprobe tcp_bbr; echo tcp_bbr > /etc/modules-load.d/bbr.conf; "
    cure = f"{load}echo net.ipv4.tcp_congestion_control=bbr > /etc/sysctl.d/60-bbr.conf; sysctl --system"
    return warning("congestion", f"{facts.active or 'unknown'} is in use: video may delay what shares its link", cure)


def check_disk(facts: RoomFacts) -> Finding:
    """Room for logs, compiled code and recordings."""
    if facts.free_bytes is None:
        return warning("disk", f"{facts.place} cannot be looked at", "run this as a user who may")
    sentence = f"{facts.free_bytes // MEGA} MB free at {facts.place}"
    if facts.free_bytes < LEAST_DISK_BYTES:
        return error("disk", sentence, "make room")
    if facts.free_bytes < LITTLE_DISK_BYTES:
        return warning("disk", sentence, "make room, before anything is recorded")
    return ok("disk", sentence)


def check_shared_memory(facts: RoomFacts) -> Finding:
    """Pictures go from process to process on one host through shared memory."""
    if facts.free_bytes is None:
        return error("shared memory", f"{facts.place} is not there", f"mount -t tmpfs tmpfs {facts.place}")
    sentence = f"{facts.free_bytes // MEGA} MB free at {facts.place}"
    if facts.free_bytes < LITTLE_SHARED_BYTES:
        cure = f"mount -o remount,size=256M {facts.place}; in a container: --shm-size=256m"
        return warning("shared memory", sentence, cure)
    return ok("shared memory", sentence)


def check_cache(facts: CacheFacts) -> Finding:
    """The tracker's machine code lasts from start to start."""
    if not facts.writable and not facts.compiled:
        cure = f"let this user write to {facts.place}, or set NUMBA_CACHE_DIR"
        return warning("compiled code", f"{facts.place} cannot be written: every start takes a minute", cure)
    if not facts.compiled:
        cure = "none is needed; to have it done now: python -m local_site.warm_up"
        return warning("compiled code", f"none yet at {facts.place}: the first start takes up to a minute", cure)
    return ok("compiled code", f"{facts.compiled} pieces at {facts.place}")
