"""Other arms than the A465 in the pipeline, hand motions for them, and how far the tool is off the hand's."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from common.geometry import Array, rotation_from_vector
from common.messages.hand import HandArm
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.motion.config import ControlConfig
from remote_site.safety.config import CollisionConfig, SafetyConfig
from tests.remote_site.remote_loop import TICK_NS, Point, RemoteLoop, hand

HandMotion = Callable[[float], tuple[Array, Array]]

ARMS = Path(__file__).parent / "arms"
SAMPLE_TICKS = 8
EXACT: dict[str, Any] = {
    "position_gain": 1.0,
    "velocity_gain": 0.8,
    "glide_rad_s": 60.0,
}  # for hand samples without noise
INDEX, THUMB = np.array([0.02, -0.17, 0.0]), np.array([-0.05, -0.1, 0.01])


def arm_config(name: str, start_deg: tuple[float, ...], **changes: Any) -> RemoteConfig:
    """An arm of the tests in an empty cell."""
    control = EXACT | {key: changes.pop(key) for key in ("solver", "singularity", "leash_m") if key in changes}
    box = {"workspace_min_m": (-2.0,) * 3, "workspace_max_m": (2.0,) * 3}
    safety: dict[str, Any] = {"collision": CollisionConfig(fixtures=())} | box | changes.pop("safety", {})
    robot = {"model": str(ARMS / f"{name}.urdf"), "acceleration_rad_s2": (10.0,), "capsules": ()} | changes
    return RemoteConfig(
        robot=RobotConfig(start_deg=start_deg, **robot),
        control=ControlConfig(**control),
        safety=SafetyConfig(**safety),
    )


OFFSET_WRIST = arm_config("offset_wrist", (-12.0, -23.0, 109.0, 6.0, -90.0, 0.0))
SEVEN_AXES = arm_config("seven_axes", (17.0, -12.0, -17.0, -100.0, 17.0, 75.0, 0.0))
A465 = RemoteConfig(robot=RobotConfig(start_deg=(0.0, 10.0, -70.0, 0.0, -30.0, 0.0)), control=ControlConfig(**EXACT))


def smooth(fraction: float) -> float:
    """From 0 to 1 without jerks at the ends."""
    s = min(max(fraction, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s * s)


def pick_and_place(t: float) -> tuple[Array, Array]:
    """Down, up, across, down, up: position (3,) in m from the start, and rotation (3,) in rad; 8 s."""
    stops = np.array([[0, 0, 0], [0, 0, -0.1], [0, 0, 0.02], [0.12, 0.06, 0.02], [0.12, 0.06, -0.1], [0.12, 0.06, 0]])
    turns = np.array([0.0, 0.0, 0.0, 0.5, 0.5, 0.5])
    leg, share = int(min(t / 1.6, 4)), smooth(t / 1.6 - min(int(t / 1.6), 4))
    place = stops[leg] + share * (stops[leg + 1] - stops[leg])
    return place, np.array([0.0, 0.0, turns[leg] + share * (turns[leg + 1] - turns[leg])])


def figure_of_eight(t: float) -> tuple[Array, Array]:
    """A lying eight of 20 x 10 cm in 6 s, the hand tilting with it; begins softly."""
    phase = 2 * np.pi / 6.0 * max(t - 0.5, 0.0) * smooth(t / 1.5)
    place = np.array([0.10 * np.sin(phase), 0.05 * np.sin(2 * phase), 0.0])
    return place, 0.25 * np.array([np.sin(phase), np.sin(2 * phase), 0.0])


def _point(position: Array) -> Point:
    x, y, z = position.tolist()
    return x, y, z


class Followed:
    """The pipeline after one hand motion: the hand's position and the tool's pose at every tick, in the base frame."""

    def __init__(
        self, config: RemoteConfig, motion: HandMotion, seconds: float, elbow: Callable[[float], Array] | None = None
    ) -> None:
        self.loop = loop = RemoteLoop(config)
        self.start = loop.model.forward(loop.sent.q)
        base_R_operator = np.array(config.mapping.base_R_operator)
        loop.run(SAMPLE_TICKS * 31, lambda _t_ns: (0.0, 0.0, 0.3))
        begin_ns, hands, tools = loop.clock.now_ns(), [], []
        loop.hand_seq = 1000
        for k in range(round(seconds * 1e9 / TICK_NS)):
            t = (loop.clock.now_ns() - begin_ns) / 1e9
            samples = [self._sample(t, motion, elbow)] if k % SAMPLE_TICKS == 0 else []
            loop.tick(*samples)
            place, turn = motion((loop.clock.now_ns() - begin_ns) / 1e9)
            hands.append((base_R_operator @ place, base_R_operator @ turn))
            tools.append(loop.model.forward(loop.sent.q).copy())
        self.hands = np.array([place for place, _ in hands])
        self.turns = np.array([turn for _, turn in hands])
        self.tools = np.array(tools)

    def _sample(self, t: float, motion: HandMotion, elbow: Callable[[float], Array] | None) -> HandArm:
        loop = self.loop
        place, turn = motion(t)
        wrist = np.array([0.0, 0.0, 0.3]) + place
        rotation = rotation_from_vector(turn)
        loop.hand_seq += 1
        elbow_at = None if elbow is None else _point(wrist + elbow(t))
        index, thumb = _point(wrist + rotation @ INDEX), _point(wrist + rotation @ THUMB)
        return hand(loop.hand_seq, loop.clock.now_ns(), _point(wrist), index=index, thumb=thumb, elbow=elbow_at)

    def off_mm(self) -> tuple[float, float, float]:
        """Lag in ms, and the tool's distance in mm from where the hand was then: worst and rms."""
        moved = self.tools[:, :3, 3] - self.start[:3, 3]
        found = []
        for lag in range(40):
            off = np.linalg.norm(moved[lag:] - self.hands[: len(self.hands) - lag], axis=1) * 1e3
            found.append((lag * TICK_NS / 1e6, float(off.max()), float(np.sqrt(np.mean(off**2)))))
        return min(found, key=lambda lag_worst_rms: lag_worst_rms[1])


def scaled(config: RemoteConfig, **mapping: Any) -> RemoteConfig:
    """The same with another mapping."""
    return msgspec.structs.replace(config, mapping=msgspec.structs.replace(config.mapping, **mapping))
