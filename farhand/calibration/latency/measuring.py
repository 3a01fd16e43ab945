"""Measures the latency of running cameras before the blinking screen, and says what to configure."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from common.cameras.camera import Camera
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.cameras.sources import recorded_fps
from common.errors import CalibrationError, CameraError, InterruptionError
from farhand.calibration.cameras import CameraSetup, open_named
from farhand.calibration.latency.delay import Delay, estimate_delay
from farhand.calibration.latency.page import PatternScreen
from farhand.calibration.latency.pattern import ShownPattern, pattern_of
from farhand.calibration.latency.watching import Watch, WatchedFrames

POLL_S = 0.2
IN_STEP_MS = 4.0


@dataclass(frozen=True, slots=True)
class CameraLatency:
    """From the middle of the exposure to a camera's time stamps (the driver's, or of arrival), ms.

    `uncertainty_ms` leaves out what is not known of the screen's own delay: `screen_uncertainty_ms`.
    """

    name: str
    latency_ms: float
    uncertainty_ms: float
    screen_uncertainty_ms: float
    stamped_by_driver: bool
    delay: Delay

    @property
    def key(self) -> str:
        """The key of the camera's settings to which the latency belongs."""
        return "stamp_latency_ms" if self.stamped_by_driver else "latency_ms"

    def __str__(self) -> str:
        until = "the driver's time stamp" if self.stamped_by_driver else "arrival"
        in_step = self.uncertainty_ms > IN_STEP_MS
        return (
            f"{self.name}: {self.latency_ms:.1f} ms from exposure to {until}, give or take {self.uncertainty_ms:.1f} ms"
            f" ({self.delay.rate_hz:.2f} frames a second, the longest gap {self.delay.longest_gap_ms:.0f} ms, "
            f"correlation {self.delay.correlation:.3f}, contrast {self.delay.contrast:.0f} grey levels)"
            f"{'; the camera runs in step with the screen: another refresh rate tells more' if in_step else ''}"
        )


def open_for_latency(sources: Mapping[str, str], setup: CameraSetup) -> list[Camera]:
    """The cameras by name, their time stamps without a latency taken off; CameraError for recordings."""
    raw = CameraSettings(latency_ms=0.0, stamp_latency_ms=0.0)
    settings = {name: setup.settings.get(name, AS_IT_IS).overridden_by(raw) for name in sources}
    cameras = open_named(sources, CameraSetup(setup.fps, settings))
    if any(recorded_fps(camera) is not None for camera in cameras):
        for camera in cameras:
            camera.close()
        raise CameraError("a recording has no latency; give running cameras")
    return cameras


def watch_screen(
    cameras: Sequence[Camera], screen: PatternScreen, should_stop: Callable[[], bool]
) -> tuple[ShownPattern, dict[str, Watch]]:
    """Read all cameras until the screen has shown its pattern; CameraError when one fails before."""
    watches = {camera.name: Watch(camera) for camera in cameras}
    while (report := screen.wait(POLL_S)) is None:
        if should_stop():
            raise InterruptionError("interrupted before the screen had shown its pattern")
        for watch in watches.values():
            if watch.failure is not None:
                raise watch.failure
    return pattern_of(report), watches


def measure(
    pattern: ShownPattern, watches: Mapping[str, Watch], screen_ms: float | None
) -> tuple[list[CameraLatency], list[str]]:
    """The latency of each camera that shows the pattern well enough, and why the others do not.

    `screen_ms` is the screen's own delay; without it, one refresh period is assumed, and may be wrong by as much.
    """
    measured, refused = [], []
    for name, watch in watches.items():
        try:
            measured.append(_latency(name, watch.stop(), pattern, screen_ms))
        except CalibrationError as error:
            refused.append(f"camera {name}: {error}")
    return measured, refused


def _latency(name: str, watched: WatchedFrames, pattern: ShownPattern, screen_ms: float | None) -> CameraLatency:
    if not len(watched.stamps_ns):
        raise CalibrationError("it gave no frames")
    delay = estimate_delay(watched.stamps_ns, watched.brightness, pattern)
    uncertainty_ms = math.hypot(delay.uncertainty_ms, pattern.clock_uncertainty_ms)
    latency_ms = delay.delay_ms - (pattern.refresh_ms if screen_ms is None else screen_ms)
    if not watched.stamped_by_driver:  # a frame cannot arrive before it is exposed
        if screen_ms is not None and latency_ms < -uncertainty_ms:
            raise CalibrationError(
                f"from the screen's change to arrival are {delay.delay_ms:.1f} ms only; --screen-ms must be less"
            )
        latency_ms = max(0.0, latency_ms)
    own_ms = pattern.refresh_ms if screen_ms is None else 0.0
    return CameraLatency(name, latency_ms, uncertainty_ms, own_ms, watched.stamped_by_driver, delay)


def as_builtins(measured: Sequence[CameraLatency]) -> list[dict[str, str | float]]:
    """Convert what was measured, for programs; `key` is that of the camera's settings."""
    names = "name", "key", "latency_ms", "uncertainty_ms", "screen_uncertainty_ms"
    return [{name: getattr(latency, name) for name in names} for latency in measured]


def describe(measured: Sequence[CameraLatency], screen_ms: float | None) -> str:
    """Describe what was measured, with the lines for the configuration."""
    lines = [str(latency) for latency in measured]
    if screen_ms is None:
        own_ms = measured[0].screen_uncertainty_ms
        lines.append(
            f"the screen's own delay is not known: {own_ms:.1f} ms, one refresh, is taken off, and all latencies may "
            "be wrong by as much; give it with --screen-ms if it was measured; the cameras' difference does not depend "
            "on it"
        )
    lines.append("for the local site's configuration:")
    for latency in measured:
        lines += [f"[operator.camera.{latency.name}]", f"{latency.key} = {latency.latency_ms:.1f}"]
    return "\n".join(lines)
