"""What a configured site needs: robot, cameras, calibration, ports, clocks, certificates; probes, and pure checks."""

import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from common.cameras.sources import Source, open_camera
from common.clock import NS_PER_S
from common.errors import CalibrationError, CameraError, ConfigError, DriverError, RefusedError, TransportError
from common.link.config import NAME_OPERATORS, ON_THIS_HOST, LinkSecurity, OperatorLinks, TlsConfig
from common.link.credentials import load_credentials
from common.link.endpoints import check_endpoint, check_free
from common.link.remote_clock import RemoteClock
from common.link.transport import open_link
from farhand.certificates.folder import read_certificate
from farhand.doctor.findings import Finding, error, ok, warning
from farhand.doctor.processes import holder_of_device, listener_on
from local_site.calibration.rig_file import load_rig
from remote_site.config import RemoteConfig

PICTURE_TIMEOUT_S = 10.0
CLOCK_TIMEOUT_NS = 2 * NS_PER_S
ROUND_TRIPS = 20
ROUND_TRIP_PERIOD_S = 0.05
SECONDS_PER_DAY = 86400.0
PERMISSION_BITS = 0o777
OLD_CALIBRATION_DAYS = 90
UNCERTAIN_NS = 5_000_000
EXPIRES_SOON_DAYS = 30
GROUP, OTHERS = 0o070, 0o007
RENEW = "where the authority is kept: farhand certificates renew CELL; then copy the pair here and restart"


def probe_robot(config: RemoteConfig) -> list[tuple[str, str, str]]:
    """Look up the driver and load the arm as the remote site does; returns (part, sentence, cure) of each mistake."""
    from remote_site.drivers.registry import check_driver  # noqa: PLC0415  # as below

    mistakes = []
    try:
        check_driver(config.driver.name)
    except DriverError as wrong:
        mistakes.append(("driver", str(wrong), "correct driver.name, or install the package that offers it"))
    try:
        from remote_site.runtime.checks import find_mistakes  # noqa: PLC0415  # the doctor also examines hosts without its libraries
    except ImportError as wrong:
        cure = "install Farhand again: pip install -e '.[sim]'"
        return [*mistakes, ("robot", f"the arm cannot be loaded: {wrong}", cure)]
    return mistakes + [(mistake.part, mistake.sentence, mistake.cure) for mistake in find_mistakes(config)]


def check_robot(model: str, driver: str, mistakes: Sequence[tuple[str, str, str]]) -> list[Finding]:
    """All that the remote site loads of its robot can be loaded; each mistake (part, sentence, cure) is a finding."""
    if not mistakes:
        return [ok("robot", f"the model {model} loads, its start posture is valid; driver {driver}")]
    return [error(part, sentence, cure) for part, sentence, cure in mistakes]


def is_ours(holder: str) -> bool:
    """Whether a process by this name is one of Farhand's."""
    return holder.startswith("farhand")


@dataclass(frozen=True, slots=True)
class CameraFacts:
    """A camera that was tried: its picture's size (width, height), or what went wrong, or who holds the device."""

    name: str
    source: str
    size_px: tuple[int, int] | None = None
    problem: str = ""
    holder: str = ""


def probe_camera(name: str, source: Source, fps: float) -> CameraFacts:
    """Read one picture from a camera, within PICTURE_TIMEOUT_S, unless another process holds its device."""
    device = Path(f"/dev/video{source}" if str(source).isdecimal() else str(source))
    holder = holder_of_device(device) if device.is_char_device() else ""
    if holder:
        return CameraFacts(name, str(source), holder=holder)
    found: list[CameraFacts] = []
    # Opening a stream may hang and cannot be interrupted; the daemon thread is then abandoned.
    thread = threading.Thread(target=lambda: found.append(_first_picture(name, source, fps)), daemon=True)
    thread.start()
    thread.join(PICTURE_TIMEOUT_S)
    timed_out = CameraFacts(name, str(source), problem=f"{source} gave no picture in {PICTURE_TIMEOUT_S:g} s")
    return found[0] if found else timed_out


def _first_picture(name: str, source: Source, fps: float) -> CameraFacts:
    try:
        camera = open_camera(source, name, fps)
        try:
            frame = camera.read()
        finally:
            camera.close()
    except CameraError as wrong:
        return CameraFacts(name, str(source), problem=str(wrong).removeprefix(f"camera {name}: "))
    if frame is None:
        return CameraFacts(name, str(source), problem=f"{source} holds no picture")
    height, width = frame.image.shape[:2]
    return CameraFacts(name, str(source), (width, height))


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


@dataclass(frozen=True, slots=True)
class RigFacts:
    """A rig file: its age in days (None where it has no date), its cameras' picture sizes, or what is wrong."""

    path: str
    age_days: float | None = None
    sizes_px: tuple[tuple[int, int] | None, ...] = ()
    problem: str = ""


def probe_rig(path: str, now: datetime) -> RigFacts:
    """Read a rig file's age at `now` and its cameras' picture sizes; a date without a time zone is taken as UTC."""
    try:
        rig = load_rig(Path(path))
    except CalibrationError as wrong:
        return RigFacts(path, problem=str(wrong))
    sizes = tuple(camera.size_px for camera in rig.cameras)
    try:
        created = datetime.fromisoformat(rig.created)
    except ValueError:
        return RigFacts(path, sizes_px=sizes)
    created_utc = created if created.tzinfo else created.replace(tzinfo=UTC)
    return RigFacts(path, (now - created_utc).total_seconds() / SECONDS_PER_DAY, sizes)


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


@dataclass(frozen=True, slots=True)
class PortFacts:
    """An endpoint to listen at: its purpose, whether it is free, else who listens there, or what is wrong."""

    purpose: str
    endpoint: str
    free: bool = False
    holder: str = ""
    problem: str = ""


def probe_port(purpose: str, endpoint: str, security: LinkSecurity) -> PortFacts:
    """Whether this host can listen on an endpoint, else which process already does."""
    try:
        check_endpoint(endpoint, security)
    except TransportError as wrong:
        return PortFacts(purpose, endpoint, problem=str(wrong))
    try:
        check_free(endpoint, security)
    except TransportError:
        return PortFacts(purpose, endpoint, holder=listener_on(int(endpoint.rpartition(":")[2])))
    return PortFacts(purpose, endpoint, free=True)


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


@dataclass(frozen=True, slots=True)
class ClockFacts:
    """The other host's clock less ours, ns, with its uncertainty; None when that site does not answer.

    `silence` is what may keep it from answering, where the link is up.
    """

    endpoint: str
    offset_ns: int | None = None
    uncertainty_ns: int = 0
    problem: str = ""
    silence: str = ""


def probe_clock(cell: str, endpoint: str, security: LinkSecurity = ON_THIS_HOST) -> ClockFacts:
    """Estimate the remote clock's offset from ROUND_TRIPS replies, or those that come within CLOCK_TIMEOUT_NS."""
    try:
        with open_link(connect=(endpoint,), security=security) as link:
            clock, round_trips = RemoteClock(link, cell), 0
            deadline_ns = time.monotonic_ns() + CLOCK_TIMEOUT_NS
            while round_trips < ROUND_TRIPS and time.monotonic_ns() < deadline_ns:
                round_trips += clock.measure() is not None
                time.sleep(ROUND_TRIP_PERIOD_S)
            silence = link.why_silent()
    except RefusedError as wrong:
        return ClockFacts(endpoint, problem=str(wrong))
    except TransportError:
        return ClockFacts(endpoint)  # the check of the links reports what is wrong with the endpoint
    estimate = clock.estimate(time.monotonic_ns())
    if estimate is None:
        return ClockFacts(endpoint, silence=silence)
    return ClockFacts(endpoint, estimate.offset.offset_ns, estimate.offset.uncertainty_ns)


def check_clock(facts: ClockFacts) -> Finding:
    """The offset of the two hosts' clocks is known well enough."""
    if facts.problem:
        return error("clocks", facts.problem, "install the same release on both sites")
    if facts.offset_ns is None:
        sentence = f"the remote site does not answer at {facts.endpoint}, so the offset of its clock is unknown"
        if facts.silence:
            return warning("clocks", f"{sentence}; {facts.silence}", "add this operator to links.operators there")
        return warning("clocks", sentence, "start the remote site; then: farhand lease show")
    sentence = f"remote minus local {facts.offset_ns / 1e6:.3f} ms, uncertainty {facts.uncertainty_ns / 1e6:.3f} ms"
    if facts.uncertainty_ns > UNCERTAIN_NS:
        return warning("clocks", sentence, "the link is slow or busy: check it (ping, other traffic)")
    return ok("clocks", sentence)


@dataclass(frozen=True, slots=True)
class CertificateFacts:
    """A certificate's file, whom it names, days until it and its authority expire, its key's mode; or what is wrong."""

    path: str
    names: str = ""
    days_left: float = 0.0
    authority_days_left: float = 0.0
    key_mode: int = 0
    problem: str = ""


def probe_certificate(tls: TlsConfig, now: datetime) -> CertificateFacts:
    """Load the files as a link would, then read the days left at `now` and the key file's mode."""
    try:
        identity = load_credentials(tls).identity
        certificates = read_certificate(Path(tls.certificate)), read_certificate(Path(tls.ca))
    except (TransportError, ConfigError) as wrong:
        return CertificateFacts(tls.certificate, problem=str(wrong))
    key_mode = Path(tls.key).stat().st_mode & PERMISSION_BITS
    days, authority_days = ((each.not_valid_after_utc - now).total_seconds() / SECONDS_PER_DAY for each in certificates)
    return CertificateFacts(tls.certificate, identity.common_name, days, authority_days, key_mode)


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


def check_operators(links: OperatorLinks) -> list[Finding]:
    """Where there are certificates, somebody may operate."""
    if not links.tls.is_given:
        return []
    if not links.operators:
        return [warning("operators", "nobody may operate: the list operators is empty", NAME_OPERATORS)]
    return [ok("operators", f"by their certificates: {', '.join(links.operators)}")]


def _check_expiry(check: str, what: str, days: float, cure: str) -> Finding:
    sentence = f"{what} expires in {days:.0f} days"
    return warning(check, sentence, cure) if days < EXPIRES_SOON_DAYS else ok(check, sentence)
