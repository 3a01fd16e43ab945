"""What a configured site needs: its robot, cameras, their calibration, ports, the other site; pure judgements."""

from dataclasses import dataclass

from farhand.doctor.findings import Finding, error, ok, warning

OLD_CALIBRATION_DAYS = 90
UNSURE_NS = 5_000_000


@dataclass(frozen=True, slots=True)
class CameraFacts:
    """A camera that was tried: its picture's size (width, height), or what went wrong, or who holds the device."""

    name: str
    source: str
    size_px: tuple[int, int] | None = None
    problem: str = ""
    holder: str = ""


@dataclass(frozen=True, slots=True)
class RigFacts:
    """A rig file: its age in days (None where it does not tell), its cameras' picture sizes, or what is wrong."""

    path: str
    age_days: float | None = None
    sizes_px: tuple[tuple[int, int] | None, ...] = ()
    problem: str = ""


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """The arm's model and the driver that were tried; name, sentence and cure of each part that will not do."""

    model: str
    driver: str
    mistakes: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class PortFacts:
    """A place where a site is to listen: what it is for, whether it is free, else who listens, or what is wrong."""

    purpose: str
    endpoint: str
    free: bool = False
    holder: str = ""
    problem: str = ""


@dataclass(frozen=True, slots=True)
class ClockFacts:
    """The other host's clock less ours, ns, with its uncertainty; None when that site does not answer."""

    endpoint: str
    offset_ns: int | None = None
    uncertainty_ns: int = 0
    problem: str = ""


def is_ours(holder: str) -> bool:
    """Whether a process by this name is one of Farhand's."""
    return holder.startswith("farhand")


def check_camera(facts: CameraFacts) -> Finding:
    """A picture came, or the site that runs has the camera."""
    check = f"camera {facts.name}"
    if facts.size_px is not None:
        width, height = facts.size_px
        return ok(check, f"{facts.source} gives pictures of {width} x {height}")
    if is_ours(facts.holder):
        return ok(check, f"{facts.source} is in use by {facts.holder}, which runs")
    if facts.holder:
        return error(check, f"{facts.source} is in use by {facts.holder}", "end that program")
    cure = "plug it in, look at its name (v4l2-ctl --list-devices), add this user to the group video"
    return error(check, facts.problem or f"{facts.source} gives no picture", cure)


def check_rig(facts: RigFacts) -> Finding:
    """The calibration can be read and is not old."""
    again = "calibrate: farhand calibrate live"
    if facts.problem:
        return error("calibration", facts.problem, again)
    if facts.age_days is None:
        return warning("calibration", f"{facts.path} does not tell its age", again)
    sentence = f"{facts.path} is {facts.age_days:.0f} days old"
    if facts.age_days > OLD_CALIBRATION_DAYS:
        return warning("calibration", sentence, f"{again}, or see that the drift alarm stays silent")
    return ok("calibration", sentence)


def check_sizes(rig: RigFacts, cameras: tuple[CameraFacts, ...]) -> list[Finding]:
    """Cameras give pictures of the size with which they were calibrated; one finding for each that does not."""
    return [
        error(
            f"camera {camera.name}",
            f"its pictures are {camera.size_px[0]} x {camera.size_px[1]}, "
            f"but it was calibrated with {size[0]} x {size[1]}",
            "set the camera to that size, or calibrate again",
        )
        for camera, size in zip(cameras, rig.sizes_px, strict=False)
        if size is not None and camera.size_px is not None and camera.size_px != size
    ]


def check_robot(facts: RobotFacts) -> list[Finding]:
    """All that the remote site loads of its robot can be loaded; one finding for each mistake."""
    if not facts.mistakes:
        return [ok("robot", f"the model {facts.model} loads, its start posture will do; driver {facts.driver}")]
    return [error(part, sentence, cure) for part, sentence, cure in facts.mistakes]


def check_port(facts: PortFacts) -> Finding:
    """The port is free, or the site that runs listens there."""
    check = f"port {facts.purpose}"
    if facts.problem:
        return error(check, facts.problem, "correct the table [links]")
    if facts.free:
        return ok(check, f"{facts.endpoint} is free")
    holder = facts.holder or "a program of another user"
    if is_ours(holder):
        return ok(check, f"{holder} listens at {facts.endpoint}")
    return error(check, f"{holder} listens at {facts.endpoint}", "end that program, or configure another port")


def check_clock(facts: ClockFacts) -> Finding:
    """The offset of the two hosts' clocks is known well enough."""
    if facts.problem:
        return error("clocks", facts.problem, "install the same release on both sites")
    if facts.offset_ns is None:
        sentence = f"the remote site does not answer at {facts.endpoint}, so its clock is not known"
        return warning("clocks", sentence, "start the remote site; then: farhand lease show")
    sentence = f"remote minus local {facts.offset_ns / 1e6:.3f} ms, sure to {facts.uncertainty_ns / 1e6:.3f} ms"
    if facts.uncertainty_ns > UNSURE_NS:
        return warning("clocks", sentence, "the link is slow or busy: look at it (ping, other traffic)")
    return ok("clocks", sentence)
