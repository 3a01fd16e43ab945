"""Looks at what a configuration names: robot, cameras, rig, ports, the remote site's clock."""

import threading
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from common.cameras.sources import Source, open_camera
from common.clock import NS_PER_S
from common.errors import CalibrationError, CameraError, DriverError, RefusedError, TransportError
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.endpoints import check_endpoint, check_free
from common.link.remote_clock import RemoteClock
from common.link.transport import open_link
from farhand.doctor.processes import holder_of_device, listener_on
from farhand.doctor.site import CameraFacts, ClockFacts, PortFacts, RigFacts, RobotFacts
from local_site.calibration.rig_file import load_rig
from remote_site.config import RemoteConfig

PICTURE_TIMEOUT_S = 10.0
CLOCK_PATIENCE_NS = 2 * NS_PER_S
TRIPS = 20
TRIP_EVERY_S = 0.05
SECONDS_PER_DAY = 86400.0


def probe_robot(config: RemoteConfig) -> RobotFacts:
    """Load of the arm what the remote site loads, and look up its driver."""
    mistakes = (*_try_driver(config.driver.name), *_try_arm(config))
    return RobotFacts(config.robot.model, config.driver.name, mistakes)


def _try_driver(name: str) -> list[tuple[str, str, str]]:
    from remote_site.drivers.registry import check_driver  # noqa: PLC0415  # as below

    try:
        check_driver(name)
    except DriverError as error:
        return [("driver", str(error), "correct driver.name, or install the package that offers it")]
    return []


def _try_arm(config: RemoteConfig) -> list[tuple[str, str, str]]:
    try:
        from remote_site.runtime.checks import find_mistakes  # noqa: PLC0415  # the doctor also looks at hosts without its libraries
    except ImportError as error:
        return [("robot", f"the arm cannot be loaded: {error}", "install Farhand anew: pip install -e '.[sim]'")]
    return [(mistake.part, mistake.sentence, mistake.cure) for mistake in find_mistakes(config)]


def probe_camera(name: str, source: Source, fps: float) -> CameraFacts:
    """Open a camera for one picture, unless another process has it."""
    device = Path(f"/dev/video{source}" if str(source).isdecimal() else str(source))
    holder = holder_of_device(device) if device.is_char_device() else ""
    if holder:
        return CameraFacts(name, str(source), holder=holder)
    found: list[CameraFacts] = []
    # A stream may hang for as long as it likes: whoever waits for it is not waited for.
    thread = threading.Thread(target=lambda: found.append(_first_picture(name, source, fps)), daemon=True)
    thread.start()
    thread.join(PICTURE_TIMEOUT_S)
    late = CameraFacts(name, str(source), problem=f"{source} gave no picture in {PICTURE_TIMEOUT_S:g} s")
    return found[0] if found else late


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
    """Read a rig file and tell its age."""
    try:
        rig = load_rig(Path(path))
    except CalibrationError as error:
        return RigFacts(path, problem=str(error))
    try:
        created = datetime.fromisoformat(rig.created)
    except ValueError:
        created = None
    sizes = tuple(camera.size_px for camera in rig.cameras)
    if created is None:
        return RigFacts(path, sizes_px=sizes)
    aware = created if created.tzinfo else created.replace(tzinfo=UTC)
    return RigFacts(path, (now - aware).total_seconds() / SECONDS_PER_DAY, sizes)


def probe_ports(endpoints: Sequence[tuple[str, str]], security: LinkSecurity) -> list[PortFacts]:
    """Whether each place (purpose, endpoint) is free to listen at."""
    return [_probe_port(purpose, endpoint, security) for purpose, endpoint in endpoints]


def _probe_port(purpose: str, endpoint: str, security: LinkSecurity) -> PortFacts:
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
    """Ask the remote site's clock some twenty times within a second or two."""
    try:
        with open_link(connect=(endpoint,), security=security) as link:
            clock, give_up_ns, trips = RemoteClock(link, cell), time.monotonic_ns() + CLOCK_PATIENCE_NS, 0
            while trips < TRIPS and time.monotonic_ns() < give_up_ns:
                trips += clock.measure() is not None
                time.sleep(TRIP_EVERY_S)
    except RefusedError as error:
        return ClockFacts(endpoint, problem=str(error))
    except TransportError:
        return ClockFacts(endpoint)  # what is wrong with the endpoint, the ports tell
    known = clock.estimate(time.monotonic_ns())
    return (
        ClockFacts(endpoint)
        if known is None
        else ClockFacts(endpoint, known.offset.offset_ns, known.offset.uncertainty_ns)
    )
