"""The cameras that see the operator: a source for each camera of the rig, one of them alone, or simulated ones."""

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from common.cameras.camera import Camera, Frame, Source
from common.cameras.settings import AS_IT_IS, DEFAULT_LATENCY_MS, CameraSettings
from common.cameras.sources import damage_of, open_camera, recorded_fps
from common.clock import Clock
from common.errors import CameraError, ConfigError
from local_site.acquisition.same_source import refuse_same
from local_site.acquisition.simulated_cameras import Beginning, SimulatedCameras
from local_site.calibration.rig import Rig
from local_site.calibration.rig_file import load_rig
from local_site.simulation.cameras import calibrate_simulated
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import Operator, make_operator
from local_site.tracking.choice import TrackingConfig

SIMULATED = "simulated"


class RecordingStart:
    """The time at which a rig's recordings began: all together, as soon as the first of them is read."""

    def __init__(self, clock: Clock) -> None:
        self._clock, self._lock = clock, threading.Lock()
        self._start_ns: int | None = None

    def wait_until(self, since_start_ns: int) -> int:
        """Wait until so long after the start; the time then, ns."""
        with self._lock:
            self._start_ns = self._clock.now_ns() if self._start_ns is None else self._start_ns
        due_ns = self._start_ns + since_start_ns
        self._clock.sleep_until_ns(due_ns)
        return due_ns


class PacedRecording:
    """A recording in the place of a live camera: its frames come at their own pace, stamped by this host's clock."""

    def __init__(self, recording: Camera, start: RecordingStart) -> None:
        self._recording, self._start = recording, start

    @property
    def name(self) -> str:
        """The camera's name."""
        return self._recording.name

    def read(self) -> Frame | None:
        """Wait for the next frame; None at the end, CameraError at that of a damaged file."""
        frame = self._recording.read()
        if frame is not None:
            return replace(frame, capture_ns=self._start.wait_until(frame.capture_ns))
        if damage := damage_of(self._recording):
            raise CameraError(damage)
        return None

    def close(self) -> None:
        """Close the recording."""
        self._recording.close()


class OperatorConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The two to four cameras before the operator, and their calibration."""

    left: Annotated[Source, Meta(description="'simulated', device, URL, file or folder")] = SIMULATED
    right: Annotated[Source, Meta(description="'simulated', device, URL, file or folder")] = SIMULATED
    also: Annotated[
        tuple[Source, ...], Meta(max_length=2, description="a third and a fourth camera, in the rig's order")
    ] = ()
    alone: Annotated[
        bool, Meta(description='left is the only camera, for tracking.method = "monocular"; right is ignored')
    ] = False
    rig: Annotated[str, Meta(description="rig file from 'farhand calibrate'; simulated cameras bring their own")] = ""
    fps: Annotated[
        float, Meta(gt=0, le=240, description="frames per second asked of the cameras, which may give others")
    ] = 30.0
    latency_ms: Annotated[
        float, Meta(ge=0, le=1000, description="exposure to arrival, of cameras whose driver gives no time stamps")
    ] = DEFAULT_LATENCY_MS
    cameras: Annotated[
        CameraSettings, Meta(description="what every live camera is set to; one that gives something else is refused")
    ] = AS_IT_IS
    camera: Annotated[
        dict[str, CameraSettings], Meta(description="the same for one camera, by its name in the rig; over cameras")
    ] = msgspec.field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.alone and (self.left == SIMULATED) != (self.right == SIMULATED):
            raise ValueError("left and right must both be simulated, or neither")
        if self.is_simulated and (self.also or self.alone):
            raise ValueError("also and alone are for real cameras; the simulated operator brings its own")
        if self.alone and self.also:
            raise ValueError("alone leaves no room for also")
        if not self.is_simulated and not self.rig:
            raise ValueError("rig is missing; make one with: farhand calibrate points CSV --out rig.json")

    @property
    def is_simulated(self) -> bool:
        """Return whether the operator is a simulated one."""
        return self.left == SIMULATED

    @property
    def sources(self) -> tuple[Source, ...]:
        """All cameras, in the rig's order."""
        return (self.left,) if self.alone else (self.left, self.right, *self.also)

    def settings_of(self, names: Sequence[str]) -> dict[str, CameraSettings]:
        """The settings of each camera by its name; ConfigError for settings of cameras that are none of these."""
        if unknown := [name for name in self.camera if name not in names]:
            raise ConfigError("\n".join(_unknown_camera(name, names) for name in unknown))
        every = CameraSettings(latency_ms=self.latency_ms).overridden_by(self.cameras)
        return {name: every.overridden_by(self.camera.get(name, AS_IT_IS)) for name in names}


def _unknown_camera(name: str, names: Sequence[str]) -> str:
    near = get_close_matches(name, names, n=1)
    cure = f"did you mean {near[0]}?" if near else f"its cameras are {', '.join(names)}"
    return f"operator.camera.{name}: the rig has no such camera; {cure}"


@dataclass(frozen=True, slots=True)
class OperatorRig:
    """The cameras that see the operator, their calibration and tracker; `engaged` is called with the time (ns)
    of the hand's origin while the arm is engaged."""

    rig: Rig
    tracking: TrackingConfig
    cameras: Sequence[Camera]
    engaged: Callable[[int], None]


def open_operator(
    operator: OperatorConfig, simulation: SimulationConfig, tracking: TrackingConfig, clock: Clock
) -> OperatorRig:
    """Open the cameras that the configuration names; FarhandError when rig or cameras cannot be used."""
    if operator.is_simulated:
        return film(simulation, tracking, make_operator(simulation), Beginning())
    rig = load_rig(Path(operator.rig))
    if operator.alone:
        rig, tracking = of_one_camera(rig, tracking)
    settings = operator.settings_of([camera.name for camera in rig.cameras])
    cameras = open_rig_cameras(rig, operator.sources, operator.fps, settings)
    start = RecordingStart(clock)
    paced = [camera if recorded_fps(camera) is None else PacedRecording(camera, start) for camera in cameras]
    return OperatorRig(rig, tracking, paced, lambda _t_ns: None)


def film(
    simulation: SimulationConfig, tracking: TrackingConfig, operator: Operator, beginning: Beginning
) -> OperatorRig:
    """Simulated cameras before an operator who begins to move at `beginning`."""
    simulated = SimulatedCameras(simulation, operator, beginning)
    rig = simulated.rig if simulation.textured else calibrate_simulated(simulation)
    return OperatorRig(rig, tracking, simulated.cameras, simulated.begin)


def of_one_camera(rig: Rig, tracking: TrackingConfig) -> tuple[Rig, TrackingConfig]:
    """The rig of the monocular tracker's camera alone, and that tracker's configuration for it; ConfigError without."""
    number, replaced = tracking.monocular.camera, msgspec.structs.replace
    if number >= len(rig.cameras):
        raise ConfigError(f"tracking.monocular.camera is {number}, but the rig has {len(rig.cameras)} cameras, from 0")
    monocular = replaced(tracking.monocular, camera=0)
    alone = replaced(tracking, method="monocular", monocular=monocular)
    return replaced(rig, cameras=(rig.cameras[number],)), alone


def open_rig_cameras(
    rig: Rig, sources: Sequence[Source], fps: float | None, settings: Mapping[str, CameraSettings] | None = None
) -> list[Camera]:
    """A camera for each of the rig's, by its name there, with the settings of that name.

    CameraError if one cannot be opened or the numbers differ, ConfigError if two are the same.
    """
    if len(sources) != len(rig.cameras):
        names = ", ".join(camera.name for camera in rig.cameras)
        raise CameraError(
            f"the rig has {len(rig.cameras)} cameras ({names}), but {len(sources)} are given: "
            "give one for each, in this order, or calibrate again with those you have"
        )
    refuse_same({own.name: source for own, source in zip(rig.cameras, sources, strict=True)})
    by_name = settings or {}
    with ExitStack() as opened:
        cameras = [
            opened.enter_context(closing(open_camera(source, own.name, fps, settings=by_name.get(own.name, AS_IT_IS))))
            for own, source in zip(rig.cameras, sources, strict=True)
        ]
        opened.pop_all()
    return cameras
