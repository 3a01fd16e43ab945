"""Two to four recordings interpolated to common instants, and what is left out of them."""

from collections import deque
from collections.abc import Iterator, Sequence

from common.cameras.camera import Camera, Frame
from common.cameras.sources import recorded_fps, stated_frames
from common.errors import ConfigError
from local_site.tracking.tracker import View, Views

MAX_RATE_RATIO = 1.01
LEAST_FPS, MOST_FPS = 0.1, 1000.0


def refuse_odd_rate(fps: float | None) -> None:
    """ConfigError if a frame rate (Hz) that is given cannot be a camera's."""
    if fps is not None and not LEAST_FPS <= fps <= MOST_FPS:
        raise ConfigError(f"--fps {fps:g}: give frames per second from {LEAST_FPS:g} to {MOST_FPS:g}")


def refuse_other_rates(cameras: Sequence[Camera]) -> None:
    """ConfigError if recordings state frame rates that differ by more than a per cent."""
    rates = {camera.name: rate for camera in cameras if (rate := recorded_fps(camera)) is not None}
    if rates and max(rates.values()) > MAX_RATE_RATIO * min(rates.values()):
        stated = ", ".join(f"{name} {rate:g}" for name, rate in rates.items())
        raise ConfigError(
            f"the recordings differ in frames per second ({stated}), so that they cannot have been exposed together; "
            "give those of one session, or with --fps the rate that all were really taken at"
        )


def stated_pairs(cameras: Sequence[Camera]) -> int | None:
    """Return how many pairs recordings state; None if a camera does not state it, as a live one."""
    counts = [stated_frames(camera) for camera in cameras]
    return None if None in counts else min(count for count in counts if count is not None)


class RecordedPairs:
    """Views at the instants of the left camera's frames, until any camera ends.

    The other cameras' measurements are interpolated between the two exposures around the instant. After the last
    views, `left_out` names the cameras that continued; empty where none did.
    """

    def __init__(self, left: Camera, *others: Camera) -> None:
        self._left = left
        self._others = [_InterpolatedCamera(camera) for camera in others]
        self.left_out = ""

    def __iter__(self) -> Iterator[Views]:
        times_ns: deque[int] = deque(maxlen=2)
        pairs = 0
        while (frame := self._left.read()) is not None:
            found = [other.at(frame.capture_ns) for other in self._others]
            views = [view for view in found if view is not None]
            if len(views) < len(found):
                ended = [f.name for f, view in zip(self._others, found, strict=True) if view is None]
                self.left_out = _left_out(ended, [self._left.name], pairs)
                return
            times_ns.append(frame.capture_ns)
            pairs += 1
            yield Views(frame.capture_ns, (View(frame), *views))
        next_ns = times_ns[-1] + max(times_ns[-1] - times_ns[0], 1) if times_ns else 0
        going_on = [f.name for f in self._others if f.at(next_ns) is not None]
        self.left_out = _left_out([self._left.name], going_on, pairs) if going_on else ""


def _left_out(ended: Sequence[str], going_on: Sequence[str], pairs: int) -> str:
    first, others = " and ".join(ended), " and ".join(going_on)
    return f"{first} ended after {pairs} pairs while {others} continued; what came later was left out"


class _InterpolatedCamera:
    """A camera that is read up to the instants of another."""

    def __init__(self, camera: Camera) -> None:
        self.name = camera.name
        self._camera = camera
        self._previous: Frame | None = None
        self._current = camera.read()

    def at(self, t_ns: int) -> View | None:
        """The view of an instant no earlier than the last; None once the camera has ended."""
        while self._current is not None and self._current.capture_ns < t_ns:
            self._previous, self._current = self._current, self._camera.read()
        previous, current = self._previous, self._current
        if current is None:
            return None
        if previous is None or current.capture_ns == t_ns:
            return View(current)
        weight = (t_ns - previous.capture_ns) / (current.capture_ns - previous.capture_ns)
        return View(current, previous, weight)
