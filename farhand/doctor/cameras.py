"""The operator's cameras: whether they do what their settings ask, and their calibration."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from common.cameras.camera import Camera, Source
from common.cameras.controls import CURE
from common.cameras.given_rate import LEAST_SHARE
from common.cameras.live import CURE_OF_RATE, LiveCamera
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.shown_source import shown_source
from common.cameras.sources import open_camera
from common.clock import NS_PER_S
from common.errors import CalibrationError, CameraError
from common.link.port_holders import holder_of_device, is_ours
from farhand.doctor.findings import Finding, error, ok, warning
from local_site.calibration.rig_file import load_rig
from local_site.kernels.pictures import as_colour
from local_site.tracking.foreground.arm_colour import is_grey
from local_site.tracking.registry import tracker_kind

PICTURE_TIMEOUT_S = 10.0
RATE_NS = 2 * NS_PER_S  # in which a camera's pictures are counted
OLD_CALIBRATION_DAYS = 90
SECONDS_PER_DAY = 86400.0
LEAST_LEVEL = 30.0  # of 255: a darker picture, as a camera's first one may be, shows no colours in any case


@dataclass(frozen=True, slots=True)
class CameraFacts:
    """A camera that was tried: its picture's size (width, height), or what went wrong, or who holds the device.

    `state` is what a live camera does, and by whom its frames are stamped, in words. `slow_fps` is how many pictures a
    second it gave where it states more. `is_grey` is whether its picture
    is bright enough to show colours and has none.
    """

    name: str
    source: str
    size_px: tuple[int, int] | None = None
    problem: str = ""
    holder: str = ""
    state: str = ""
    is_grey: bool = False
    slow_fps: float | None = None


def probe_camera(name: str, source: Source, fps: float, settings: CameraSettings = AS_IT_IS) -> CameraFacts:
    """Set a camera up and read a picture, within PICTURE_TIMEOUT_S, unless another process holds its device."""
    device = Path(f"/dev/video{source}" if str(source).isdecimal() else str(source))
    holder, shown = holder_of_device(device) if device.is_char_device() else "", shown_source(source)
    if holder:
        return CameraFacts(name, shown, holder=holder)
    found: list[CameraFacts] = []
    # Opening a stream may hang and cannot be interrupted; the daemon thread is then abandoned.
    thread = threading.Thread(target=lambda: found.append(_first_picture(name, source, fps, settings)), daemon=True)
    thread.start()
    thread.join(PICTURE_TIMEOUT_S)
    timed_out = CameraFacts(name, shown, problem=f"{shown} gave no picture in {PICTURE_TIMEOUT_S:g} s")
    return found[0] if found else timed_out


def _first_picture(name: str, source: Source, fps: float, settings: CameraSettings) -> CameraFacts:
    shown = shown_source(source)
    try:
        camera = open_camera(source, name, fps, settings=settings)
        try:
            frame, slow_fps = camera.read(), _slow_fps(camera)
        finally:
            camera.close()
    except CameraError as wrong:
        return CameraFacts(name, shown, problem=str(wrong).removeprefix(f"camera {name}: "))
    if frame is None:
        return CameraFacts(name, shown, problem=f"{shown} holds no picture")
    height, width = frame.image.shape[:2]
    picture = as_colour(frame.image)
    colourless = float(picture.mean()) > LEAST_LEVEL and is_grey(picture)
    return CameraFacts(name, shown, (width, height), state=_state_of(camera), is_grey=colourless, slow_fps=slow_fps)


def _slow_fps(camera: Camera) -> float | None:
    """Measure how many pictures a second a live camera gives; None unless that is less than it states."""
    if not isinstance(camera, LiveCamera) or camera.state.fps is None:
        return None
    count, first = 0, camera.read()
    last = first
    while first is not None and last is not None and last.capture_ns - first.capture_ns < RATE_NS:
        count, last = count + 1, camera.read()
    if first is None or last is None:
        return None
    fps = count * NS_PER_S / (last.capture_ns - first.capture_ns)
    return fps if fps < LEAST_SHARE * camera.state.fps else None


def _state_of(camera: Camera) -> str:
    if not isinstance(camera, LiveCamera):
        return ""
    return f"{camera.state}; frames are stamped by {'its driver' if camera.stamped_by_driver else 'their arrival'}"


def check_camera(facts: CameraFacts) -> Finding:
    """A picture came and the camera does what its settings ask, or the running site has the camera."""
    check = f"camera {facts.name}"
    if facts.size_px is not None:
        width, height = facts.size_px
        if facts.slow_fps is not None:
            given = f"{facts.source} gives {facts.slow_fps:.1f} pictures a second, and states: {facts.state}"
            return warning(check, given, CURE_OF_RATE)
        return ok(check, f"{facts.source} gives {facts.state or f'pictures of {width} x {height}'}")
    if is_ours(facts.holder):
        return ok(check, f"{facts.source} is in use by {facts.holder}, which is running")
    if facts.holder:
        return error(check, f"{facts.source} is in use by {facts.holder}", "stop that program")
    if CURE in facts.problem:
        wrong, _, cure = facts.problem.partition(CURE)
        return error(check, wrong, cure)
    cure = "plug it in, check its name (v4l2-ctl --list-devices), and add this user to the group video"
    return error(check, facts.problem or f"{facts.source} gives no picture", cure)


@dataclass(frozen=True, slots=True)
class RigFacts:
    """A rig file: its age in days (None where it has no date), its cameras' picture sizes and names, or a problem."""

    path: str
    age_days: float | None = None
    sizes_px: tuple[tuple[int, int] | None, ...] = ()
    problem: str = ""
    names: tuple[str, ...] = ()


def probe_rig(path: str, now: datetime) -> RigFacts:
    """Read a rig file's age at `now` and its cameras' picture sizes; a date without a time zone is taken as UTC."""
    try:
        rig = load_rig(Path(path))
    except CalibrationError as wrong:
        return RigFacts(path, problem=str(wrong))
    sizes, names = (tuple(camera.size_px for camera in rig.cameras), tuple(camera.name for camera in rig.cameras))
    try:
        created = datetime.fromisoformat(rig.created)
    except ValueError:
        return RigFacts(path, sizes_px=sizes, names=names)
    created_utc = created if created.tzinfo else created.replace(tzinfo=UTC)
    return RigFacts(path, (now - created_utc).total_seconds() / SECONDS_PER_DAY, sizes, names=names)


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


def check_colours(method: str, cameras: Sequence[CameraFacts]) -> list[Finding]:
    """A tracker for rooms gets colours, by which it tells the arm; one finding for each grey camera."""
    if tracker_kind(method).scene != "room":
        return []
    return [
        warning(
            f"camera {camera.name}",
            f"its pictures are grey, but the tracker {method} tells the arm from a room by its colour",
            "take a camera that gives colour, or hang dark cloth behind the arm",
        )
        for camera in cameras
        if camera.is_grey
    ]
