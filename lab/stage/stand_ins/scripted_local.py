"""Runs 'farhand local' with scripted cameras and tracker.

python -m lab.stage.stand_ins.scripted_local SOCKET --set ...
"""

import struct
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import CameraError
from common.geometry import Array, rotation_from_vector
from common.messages.hand import TrackingStatus
from farhand.__main__ import main
from lab.stage.network.command_socket import CommandSocket
from lab.stage.stand_ins.hand_path import ScriptedPath
from local_site.acquisition.rig_cameras import OperatorConfig, OperatorRig
from local_site.runtime import app, loop
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.tracking.choice import TrackingConfig
from local_site.tracking.tracker import ArmEstimate, Views

FRAME_NS = NS_PER_S // 30
EXPOSURE_NS = 8 * NS_PER_MS
HOME = np.array([0.0, 0.0, 0.3])
ELBOW, INDEX, THUMB = np.array([[0.0, 0.25, 0.0], [0.02, -0.17, 0.0], [-0.05, -0.1, 0.01]])
PALM = np.array([0.0, -0.06, 0.0])
COVARIANCE = 1e-6 * np.eye(3)


class SlewedClock:
    """Gains `rate` of the time; the kernel's CLOCK_BOOTTIME does too, and CLOCK_MONOTONIC_RAW does not."""

    def __init__(self) -> None:
        self._monotonic_ns, self._clock_ns = time.monotonic_ns, time.clock_gettime_ns
        self._rate, self._since_ns, self._gained_ns = 0.0, self._monotonic_ns(), 0.0

    def slew(self, rate: float) -> None:
        """Gain at this rate from now on, or lose where it is negative; what was gained stays."""
        now_ns = self._monotonic_ns()
        self._gained_ns += self._rate * (now_ns - self._since_ns)
        self._rate, self._since_ns = rate, now_ns

    def now_ns(self) -> int:
        """As `time.monotonic_ns`."""
        now_ns = self._monotonic_ns()
        return now_ns + round(self._gained_ns + self._rate * (now_ns - self._since_ns))

    def read_ns(self, clock: int) -> int:
        """As `time.clock_gettime_ns`."""
        read_ns = self._clock_ns(clock)
        is_slewed = clock in (time.CLOCK_MONOTONIC, time.CLOCK_BOOTTIME)
        return read_ns + self.now_ns() - self._monotonic_ns() if is_slewed else read_ns


@contextmanager
def slewed_clock() -> Iterator[SlewedClock]:
    """Have this process read such a clock, which is not slewed yet."""
    clock = SlewedClock()
    with patch.object(time, "monotonic_ns", clock.now_ns), patch.object(time, "clock_gettime_ns", clock.read_ns):
        yield clock


class Script:
    """The script of the operator's hand and the cameras, as commanded so far."""

    def __init__(self, commands: CommandSocket, clock: SlewedClock) -> None:
        self._commands, self._clock = commands, clock
        self.path = ScriptedPath.still()
        self._jump_m, self._jumps = np.zeros(3), 0
        self.lost = self.open = self.swapped = self.inferred = False
        self.camera = ""
        self.palm_sigma_m: float | None = None  # None: it measures none, like every tracker of two cameras

    def jump(self) -> Array:
        """Return how far the next sample is off, m, and count it."""
        self._jumps -= 1
        return self._jump_m if self._jumps >= 0 else np.zeros(3)

    def listen(self) -> None:
        """Carry out the commands that came since the last frame."""
        while fields := self._commands.take():
            self.lost, self.camera = fields.get("lost", self.lost), fields.get("camera", self.camera)
            self.open = fields.get("open", self.open)
            self.swapped, self.inferred = fields.get("swapped", self.swapped), fields.get("inferred", self.inferred)
            self.palm_sigma_m = fields.get("palm_sigma_m", self.palm_sigma_m)
            if "slew" in fields:
                self._clock.slew(fields["slew"])
            if "jump_m" in fields:
                self._jump_m, self._jumps = np.array(fields["jump_m"]), fields["jumps"]
            if "to" in fields:
                self.path = self.path.then(fields)


class ScriptedCamera:
    """A picture of the time, 30 times a second; the script decides when there is none, late, or always the same."""

    def __init__(self, name: str, script: Script) -> None:
        self._name, self._script = name, script
        self._seq = 0
        self._due_ns = time.monotonic_ns() // FRAME_NS * FRAME_NS
        self._image = np.zeros((48, 64), np.uint8)

    @property
    def name(self) -> str:
        return self._name

    def read(self) -> Frame:
        """The next frame, 8 ms after its exposure began."""
        trouble = self._script.camera if self._name == "left" else ""
        while trouble == "off" and self._script.camera == "off":
            time.sleep(0.005)
        if trouble == "unplugged":
            raise CameraError("it was unplugged")
        self._due_ns += FRAME_NS * (5 if trouble == "slow" else 1)
        self._due_ns = max(self._due_ns, time.monotonic_ns() // FRAME_NS * FRAME_NS)
        time.sleep(max(self._due_ns + EXPOSURE_NS - time.monotonic_ns(), 0) / NS_PER_S)
        self._seq += 1
        if trouble != "stuck":
            self._image = np.zeros((48, 64), np.uint8)
            self._image[0, :8] = np.frombuffer(struct.pack("<q", self._due_ns), np.uint8)
        return Frame(self._image, self._due_ns, self._seq)

    def close(self) -> None:
        pass


class ScriptedTracker:
    """Sees the hand as it was when the oldest of the pictures was exposed."""

    def __init__(self, script: Script) -> None:
        self._script = script

    def track(self, views: Views) -> ArmEstimate:
        """The scripted hand at the time of the views."""
        if self._script.lost:
            return ArmEstimate(views.t_ns, TrackingStatus.LOST, "as scripted")
        shown = min(struct.unpack("<q", view.current.image[0, :8].tobytes())[0] for view in views.views)
        pose = self._script.path.at(min(shown, views.t_ns))
        wrist, rotation = HOME + pose[:3] + self._script.jump(), rotation_from_vector(pose[3:])
        index, thumb = (THUMB, INDEX) if self._script.swapped else (INDEX, THUMB)
        points = {"wrist": wrist, "index": wrist + rotation @ index, "thumb": wrist + rotation @ thumb}
        covariances = dict.fromkeys(("elbow", *points), COVARIANCE)
        if self._script.palm_sigma_m is not None:
            points["palm"] = wrist + rotation @ PALM
            covariances["palm"] = self._script.palm_sigma_m**2 / 3 * np.eye(3)
        return ArmEstimate(
            views.t_ns,
            TrackingStatus.TRACKED,
            "",
            elbow=wrist + ELBOW,
            covariances=covariances,
            thumb_inferred=self._script.inferred,
            hand_open=self._script.open,
            **points,
        )


class ListeningCamera(ScriptedCamera):
    """The camera that never fails; it also receives the script's commands."""

    def read(self) -> Frame:
        """The next frame."""
        self._script.listen()
        return super().read()


def run() -> None:
    """The command line of Farhand, with a scripted operator."""
    with slewed_clock() as clock:
        run_scripted(Script(CommandSocket(sys.argv.pop(1)), clock))


def run_scripted(script: Script) -> None:
    """The command line of Farhand, with this operator."""

    def open_operator(
        _: OperatorConfig, simulation: SimulationConfig, tracking: TrackingConfig, __: Clock
    ) -> OperatorRig:
        cameras = ScriptedCamera("left", script), ListeningCamera("right", script)
        return OperatorRig(exact_rig(simulation.stereo), tracking, cameras, lambda _t_ns: None)

    sys.argv.insert(1, "local")
    with (
        patch.object(app, "open_operator", open_operator),
        patch.object(loop, "make_tracker", lambda *_: ScriptedTracker(script)),
    ):
        main()


if __name__ == "__main__":
    run()
