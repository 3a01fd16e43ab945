"""Gathers the facts about what a configuration names: robot, cameras, rig, ports, remote clock, certificates."""

import threading
import time
from datetime import UTC, datetime
from pathlib import Path

from cryptography import x509

from common.cameras.sources import Source, open_camera
from common.clock import NS_PER_S
from common.errors import CalibrationError, CameraError, ConfigError, DriverError, RefusedError, TransportError
from common.link.config import ON_THIS_HOST, LinkSecurity, TlsConfig
from common.link.credentials import load_credentials
from common.link.endpoints import check_endpoint, check_free
from common.link.remote_clock import RemoteClock
from common.link.transport import open_link
from farhand.certificates.folder import read_certificate
from farhand.doctor.processes import holder_of_device, listener_on
from farhand.doctor.site import CameraFacts, CertificateFacts, ClockFacts, PortFacts, RigFacts
from local_site.calibration.rig_file import load_rig
from remote_site.config import RemoteConfig

PICTURE_TIMEOUT_S = 10.0
CLOCK_TIMEOUT_NS = 2 * NS_PER_S
ROUND_TRIPS = 20
ROUND_TRIP_PERIOD_S = 0.05
SECONDS_PER_DAY = 86400.0
PERMISSION_BITS = 0o777


def probe_robot(config: RemoteConfig) -> list[tuple[str, str, str]]:
    """Look up the driver and load the arm as the remote site does; returns (part, sentence, cure) of each mistake."""
    return [*_driver_mistakes(config.driver.name), *_arm_mistakes(config)]


def _driver_mistakes(name: str) -> list[tuple[str, str, str]]:
    from remote_site.drivers.registry import check_driver  # noqa: PLC0415  # as in _arm_mistakes

    try:
        check_driver(name)
    except DriverError as error:
        return [("driver", str(error), "correct driver.name, or install the package that offers it")]
    return []


def _arm_mistakes(config: RemoteConfig) -> list[tuple[str, str, str]]:
    try:
        from remote_site.runtime.checks import find_mistakes  # noqa: PLC0415  # the doctor also examines hosts without its libraries
    except ImportError as error:
        return [("robot", f"the arm cannot be loaded: {error}", "install Farhand again: pip install -e '.[sim]'")]
    return [(mistake.part, mistake.sentence, mistake.cure) for mistake in find_mistakes(config)]


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
    except CameraError as error:
        return CameraFacts(name, str(source), problem=str(error).removeprefix(f"camera {name}: "))
    if frame is None:
        return CameraFacts(name, str(source), problem=f"{source} holds no picture")
    height, width = frame.image.shape[:2]
    return CameraFacts(name, str(source), (width, height))


def probe_rig(path: str, now: datetime) -> RigFacts:
    """Read a rig file's age at `now` and its cameras' picture sizes; a date without a time zone is taken as UTC."""
    try:
        rig = load_rig(Path(path))
    except CalibrationError as error:
        return RigFacts(path, problem=str(error))
    sizes = tuple(camera.size_px for camera in rig.cameras)
    try:
        created = datetime.fromisoformat(rig.created)
    except ValueError:
        return RigFacts(path, sizes_px=sizes)
    created_utc = created if created.tzinfo else created.replace(tzinfo=UTC)
    return RigFacts(path, (now - created_utc).total_seconds() / SECONDS_PER_DAY, sizes)


def probe_port(purpose: str, endpoint: str, security: LinkSecurity) -> PortFacts:
    """Whether this host can listen on an endpoint, else which process already does."""
    try:
        check_endpoint(endpoint, security)
    except TransportError as error:
        return PortFacts(purpose, endpoint, problem=str(error))
    try:
        check_free(endpoint, security)
    except TransportError:
        return PortFacts(purpose, endpoint, holder=listener_on(int(endpoint.rpartition(":")[2])))
    return PortFacts(purpose, endpoint, free=True)


def probe_clock(cell: str, endpoint: str, security: LinkSecurity = ON_THIS_HOST) -> ClockFacts:
    """Estimate the remote clock's offset from ROUND_TRIPS replies, or those that come within CLOCK_TIMEOUT_NS."""
    try:
        with open_link(connect=(endpoint,), security=security) as link:
            clock, round_trips = RemoteClock(link, cell), 0
            deadline_ns = time.monotonic_ns() + CLOCK_TIMEOUT_NS
            while round_trips < ROUND_TRIPS and time.monotonic_ns() < deadline_ns:
                round_trips += clock.measure() is not None
                time.sleep(ROUND_TRIP_PERIOD_S)
    except RefusedError as error:
        return ClockFacts(endpoint, problem=str(error))
    except TransportError:
        return ClockFacts(endpoint)  # the check of the links reports what is wrong with the endpoint
    estimate = clock.estimate(time.monotonic_ns())
    if estimate is None:
        return ClockFacts(endpoint)
    return ClockFacts(endpoint, estimate.offset.offset_ns, estimate.offset.uncertainty_ns)


def probe_certificate(tls: TlsConfig, now: datetime) -> CertificateFacts:
    """Load the files as a link would, then read the days left at `now` and the key file's mode."""
    try:
        identity = load_credentials(tls).identity
        certificate, authority = read_certificate(Path(tls.certificate)), read_certificate(Path(tls.ca))
    except (TransportError, ConfigError) as error:
        return CertificateFacts(tls.certificate, problem=str(error))
    key_mode = Path(tls.key).stat().st_mode & PERMISSION_BITS
    days = _days_left(certificate, now), _days_left(authority, now)
    return CertificateFacts(tls.certificate, identity.common_name, *days, key_mode)


def _days_left(certificate: x509.Certificate, now: datetime) -> float:
    return (certificate.not_valid_after_utc - now).total_seconds() / SECONDS_PER_DAY
