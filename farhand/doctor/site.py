"""What a configured site needs: robot, cameras, calibration, ports, clocks, certificates; pure judgements of facts."""

from collections.abc import Sequence
from dataclasses import dataclass

from farhand.doctor.findings import Finding, error, ok, warning

OLD_CALIBRATION_DAYS = 90
UNCERTAIN_NS = 5_000_000
EXPIRES_SOON_DAYS = 30
GROUP, OTHERS = 0o070, 0o007
RENEW = "where the authority is kept: farhand certificates renew CELL; then copy the pair here and restart"


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
    """A rig file: its age in days (None where it has no date), its cameras' picture sizes, or what is wrong."""

    path: str
    age_days: float | None = None
    sizes_px: tuple[tuple[int, int] | None, ...] = ()
    problem: str = ""


@dataclass(frozen=True, slots=True)
class PortFacts:
    """An endpoint to listen at: its purpose, whether it is free, else who listens there, or what is wrong."""

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


@dataclass(frozen=True, slots=True)
class CertificateFacts:
    """A certificate's file, whom it names, days until it and its authority expire, its key's mode; or what is wrong."""

    path: str
    names: str = ""
    days_left: float = 0.0
    authority_days_left: float = 0.0
    key_mode: int = 0
    problem: str = ""


def is_ours(holder: str) -> bool:
    """Whether a process by this name is one of Farhand's."""
    return holder.startswith("farhand")


def check_camera(facts: CameraFacts) -> Finding:
    """A picture came, or the running site has the camera."""
    check = f"camera {facts.name}"
    if facts.size_px is not None:
        width, height = facts.size_px
        return ok(check, f"{facts.source} gives pictures of {width} x {height}")
    if is_ours(facts.holder):
        return ok(check, f"{facts.source} is in use by {facts.holder}, which is running")
    if facts.holder:
        return error(check, f"{facts.source} is in use by {facts.holder}", "stop that program")
    cure = "plug it in, check its name (v4l2-ctl --list-devices), and add this user to the group video"
    return error(check, facts.problem or f"{facts.source} gives no picture", cure)


def check_rig(facts: RigFacts) -> Finding:
    """The calibration can be read and is not old."""
    calibrate = "calibrate: farhand calibrate live"
    if facts.problem:
        return error("calibration", facts.problem, calibrate)
    if facts.age_days is None:
        return warning("calibration", f"{facts.path} has no date", calibrate)
    sentence = f"{facts.path} is {facts.age_days:.0f} days old"
    if facts.age_days > OLD_CALIBRATION_DAYS:
        return warning("calibration", sentence, f"{calibrate}, or check that the drift alarm stays silent")
    return ok("calibration", sentence)


def check_sizes(rig: RigFacts, cameras: Sequence[CameraFacts]) -> list[Finding]:
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


def check_robot(model: str, driver: str, mistakes: Sequence[tuple[str, str, str]]) -> list[Finding]:
    """All that the remote site loads of its robot can be loaded; each mistake (part, sentence, cure) is a finding."""
    if not mistakes:
        return [ok("robot", f"the model {model} loads, its start posture is valid; driver {driver}")]
    return [error(part, sentence, cure) for part, sentence, cure in mistakes]


def check_port(facts: PortFacts) -> Finding:
    """The port is free, or the running site listens there."""
    check = f"port {facts.purpose}"
    if facts.problem:
        return error(check, facts.problem, "correct the table [links]")
    if facts.free:
        return ok(check, f"{facts.endpoint} is free")
    holder = facts.holder or "a program of another user"
    if is_ours(holder):
        return ok(check, f"{holder} listens at {facts.endpoint}")
    return error(check, f"{holder} listens at {facts.endpoint}", "stop that program, or configure another port")


def check_clock(facts: ClockFacts) -> Finding:
    """The offset of the two hosts' clocks is known well enough."""
    if facts.problem:
        return error("clocks", facts.problem, "install the same release on both sites")
    if facts.offset_ns is None:
        sentence = f"the remote site does not answer at {facts.endpoint}, so the offset of its clock is unknown"
        return warning("clocks", sentence, "start the remote site; then: farhand lease show")
    sentence = f"remote minus local {facts.offset_ns / 1e6:.3f} ms, uncertainty {facts.uncertainty_ns / 1e6:.3f} ms"
    if facts.uncertainty_ns > UNCERTAIN_NS:
        return warning("clocks", sentence, "the link is slow or busy: check it (ping, other traffic)")
    return ok("clocks", sentence)


def check_certificate(facts: CertificateFacts, expected: str) -> list[Finding]:
    """It is valid now and for a while, it is for this site (`expected`), and no other user can read its key."""
    if facts.problem:
        return [error("certificate", facts.problem, RENEW)]
    findings = [_check_expiry("certificate", f"{facts.path} of {facts.names}", facts.days_left, RENEW)]
    if facts.authority_days_left < EXPIRES_SOON_DAYS:
        cure = "make a new authority in a new folder: farhand certificates create CELL --dir NEW, for all hosts at once"
        findings.append(_check_expiry("certificate authority", "it", facts.authority_days_left, cure))
    if facts.names != expected:
        sentence = f"{facts.path} is for {facts.names}, not for {expected}"
        findings.append(error("certificate", sentence, "give this site its own certificate in the table [links.tls]"))
    if facts.key_mode & (GROUP | OTHERS):
        judge = error if facts.key_mode & OTHERS else warning
        whose = "everybody on this host" if facts.key_mode & OTHERS else "its group"
        findings.append(judge("certificate key", f"{whose} can read the key of {facts.path}", "chmod 600 the key"))
    return findings


def _check_expiry(check: str, what: str, days: float, cure: str) -> Finding:
    sentence = f"{what} expires in {days:.0f} days"
    return warning(check, sentence, cure) if days < EXPIRES_SOON_DAYS else ok(check, sentence)
