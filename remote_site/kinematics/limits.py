"""The joints' limits: the robot's own, which configuration can only tighten."""

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from common.errors import ConfigError, ModelError
from common.geometry import Array
from remote_site.kinematics.config import MODELS, UNSTATED_JERK_RAD_S3, RobotConfig
from remote_site.kinematics.model import ArmModel

TARGET_SPEED = 0.9  # of a joint's speed, for its target: the joint must be quicker to catch it


@dataclass(frozen=True, slots=True)
class JointRange:
    """The joints' own positions (rad) and velocity (rad/s), each (n,), which configuration does not tighten."""

    lower: Array
    upper: Array
    velocity: Array


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Positions (rad, margin included), velocity (rad/s), acceleration (rad/s²) and jerk (rad/s³), each (n,)."""

    names: tuple[str, ...]
    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array

    @classmethod
    def from_model(cls, model: ArmModel, config: RobotConfig) -> Self:
        """The model's limits, tightened; ConfigError names every joint whose configuration widens them."""
        lower, upper = _positions(model, config)
        factor = config.limits_factor
        return cls(
            names=model.joint_names,
            lower=lower,
            upper=upper,
            velocity=factor * config.speed * model.velocity,
            acceleration=factor * _accelerations(model, config),
            jerk=factor * _jerks(model, config),
        )

    def pace(self, dq: Array, ddq: Array) -> float:
        """The greatest fraction of its speed that a joint reaches, also once its acceleration is taken back."""
        taken_back = dq + ddq * np.abs(ddq) / (2 * self.jerk)
        return float((np.maximum(np.abs(dq), np.abs(taken_back)) / self.velocity).max())

    def scaled_speed(self, scale: float) -> Self:
        """The same limits with the velocities times `scale` (0 to 1]."""
        if not 0 < scale <= 1:
            raise ValueError(f"a speed scale of {scale} would widen the limits")
        return replace(self, velocity=self.velocity * scale)


def stoppable(distance: float, acceleration: float, jerk: float) -> float:
    """The speed in rad/s from which a joint without acceleration stops within `distance` rad; 0 for negative ones."""
    distance = max(distance, 0.0)
    ramp = acceleration * acceleration / (2 * jerk)
    gentle = math.cbrt(distance * distance * jerk)
    return gentle if gentle <= 2 * ramp else math.sqrt(ramp * ramp + 2 * acceleration * distance) - ramp


def _positions(model: ArmModel, config: RobotConfig) -> tuple[Array, Array]:
    mistakes = [
        f"robot.position_deg: there is no joint {name!r}; the joints are {', '.join(model.joint_names)}"
        for name in config.position_deg
        if name not in model.joint_names
    ]
    lower, upper = model.lower.copy(), model.upper.copy()
    for i, name in enumerate(model.joint_names):
        if name in config.position_deg:
            low, high = (math.radians(v) for v in config.position_deg[name])
            mistakes += _widening(name, (low, high), (lower[i], upper[i]))
            lower[i], upper[i] = low, high
    margin = math.radians(config.position_margin_deg)
    lower, upper = lower + margin, upper - margin
    mistakes += [
        f"{name}: the limits and the margin of {config.position_margin_deg} deg leave no room"
        for name, low, high in zip(model.joint_names, lower, upper, strict=True)
        if not low < high
    ]
    if mistakes:
        raise ConfigError("\n".join(mistakes))
    return lower, upper


def load_model(config: RobotConfig) -> ArmModel:
    """The configured arm; ConfigError says where its file was looked for, or why it cannot be used."""
    if not config.urdf.is_file():
        built_in = ", ".join(sorted(path.name for path in MODELS.iterdir() if path.is_dir()))
        raise ConfigError(
            f"robot.model {config.model!r} is neither a built-in model ({built_in}) nor the file of a URDF: there is "
            f"no {config.urdf.absolute()}; put it there, or give its path, in a configuration as seen from the "
            "configuration's folder, in --set from the working folder"
        )
    try:
        return ArmModel.from_urdf(config.urdf, config.tool_frame, config.tool_T_tcp)
    except ModelError as error:
        raise ConfigError(" ".join(str(error).split())) from error


def load_arm(config: RobotConfig) -> tuple[ArmModel, JointLimits]:
    """The configured arm and its limits; ConfigError where either cannot be built."""
    model = load_model(config)
    return model, JointLimits.from_model(model, config)


def _accelerations(model: ArmModel, config: RobotConfig) -> Array:
    given, joints = config.acceleration_rad_s2, len(model.joint_names)
    if len(given) not in (1, joints):
        raise ConfigError(f"robot.acceleration_rad_s2 has {len(given)} values; give one, or one for each of {joints}")
    wanted: Array = np.array(given) * np.ones(joints)
    mistakes = [
        f"robot.acceleration_rad_s2: {value:g} for {name} is above the robot's own {own:g}; limits only tighten"
        for name, value, own in zip(model.joint_names, wanted.tolist(), model.acceleration.tolist(), strict=True)
        if not value <= own
    ]
    if mistakes:
        raise ConfigError("\n".join(mistakes))
    return wanted


def _jerks(model: ArmModel, config: RobotConfig) -> Array:
    if isinstance(config.jerk_rad_s3, str):
        return model.jerk.copy()
    wanted = config.jerk_rad_s3
    mistakes = [
        f"robot.jerk_rad_s3: {wanted:g} for {name} is above {_own_jerk(model, name, own)}; limits only tighten"
        for name, own in zip(model.joint_names, model.jerk.tolist(), strict=True)
        if not wanted <= own
    ]
    if mistakes:
        raise ConfigError("\n".join(mistakes))
    return np.full(len(model.joint_names), wanted)


def _own_jerk(model: ArmModel, name: str, own: float) -> str:
    if name not in model.without_jerk:
        return f"the arm's own {own:g}"
    return f'{UNSTATED_JERK_RAD_S3:g}, which counts where an arm\'s file states no jerk (jerk="…" in <limit>)'


def _widening(name: str, wanted: tuple[float, float], own: tuple[float, float]) -> list[str]:
    if own[0] <= wanted[0] and wanted[1] <= own[1]:
        return []
    wanted_deg, own_deg = (tuple(round(math.degrees(v), 2) for v in pair) for pair in (wanted, own))
    return [f"robot.position_deg.{name} = {wanted_deg} is wider than the robot's own {own_deg}; limits only tighten"]
