"""Messages received of a cell, and how often: the newest state, the rates of states and pictures; no I/O."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from common.clock import NS_PER_S
from common.messages.requests import Description
from common.messages.robot import RobotState
from common.messages.video import CameraStatus, VideoFrame

OVER_NS = 3 * NS_PER_S
MOST_ARRIVALS = 1000


class ArrivalRate:
    """The messages per second of the last three seconds, or since the first."""

    def __init__(self) -> None:
        self._times_ns: deque[int] = deque(maxlen=MOST_ARRIVALS)

    def note(self, now_ns: int) -> None:
        """One came now."""
        self._times_ns.append(now_ns)

    def at(self, now_ns: int) -> float | None:
        """Messages a second; 0 after three seconds without any, None before the second message."""
        times_ns = list(self._times_ns)  # another thread may note one meanwhile
        if not times_ns:
            return None
        lately = [t_ns for t_ns in times_ns if now_ns - t_ns < OVER_NS]
        if not lately:
            return 0.0
        over_ns = now_ns - lately[0]
        return (len(lately) - 1) * NS_PER_S / over_ns if len(lately) > 1 and over_ns > 0 else None


@dataclass
class ObservedCamera:
    """One camera's pictures: how often they come, and what its newest message says of it."""

    rate: ArrivalRate = field(default_factory=ArrivalRate)
    status: CameraStatus | None = None
    reason: str = ""

    def take(self, frame: VideoFrame, now_ns: int) -> None:
        """Take a message of the camera."""
        self.status, self.reason = frame.status, frame.reason
        if frame.data:
            self.rate.note(now_ns)


class Observed:
    """Everything known of a cell; each of its parts has one thread that writes it."""

    def __init__(self, endpoint: str, cell: str) -> None:
        self.endpoint, self.cell = endpoint, cell
        self.state: RobotState | None = None
        self.state_rate = ArrivalRate()
        self.received_ns = 0
        self.description: Description | None = None
        self.cameras: dict[str, ObservedCamera] = {}
        self.round_trip_ms: float | None = None
        self.pictures = "not counted yet"

    def take_state(self, state: RobotState, now_ns: int) -> None:
        """Take a state."""
        self.received_ns, self.state = now_ns, state  # in this order: another thread waits for the state
        self.state_rate.note(now_ns)

    def expect(self, cameras: Iterable[str]) -> None:
        """Count the pictures of these cameras from now on."""
        self.cameras = {name: ObservedCamera() for name in cameras}
