"""The limits, tool and payload of a configured arm with their sources, and what its stops take; pure."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from farhand.limits.sources import FILE, assumed_in_configuration, file_source, of_another_arm
from farhand.limits.tool_rows import Row, tool_rows
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import UNSTATED_JERK_RAD_S3
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.safety.stop_bound import longest_stops
from remote_site.safety.stop_figures import StopFigures, rising_stop, steady_stop, way
from remote_site.session.age_limit import AgeLimit, speed_scale_at

MS = 1000.0
SPEEDS_RAD_S = (0.5, 1.0)  # beside full speed
TICKS = 2  # from the tick that finds a sample too old to the first command of the stop that a robot obeys


@dataclass(frozen=True, slots=True)
class LimitRow:
    """One limit of every joint: its key for programs, its name for people, the values, where they come from."""

    key: str
    name: str
    values: tuple[float, ...]
    source: str


@dataclass(frozen=True, slots=True)
class StopRow:
    """What a stop takes from a speed that no joint exceeds: from steady motion, and while still accelerating."""

    speed_rad_s: float
    steady: StopFigures
    rising: StopFigures


@dataclass(frozen=True, slots=True)
class AgeRow:
    """From the exposure of the last good sample to rest, at an age limit and the speed that it leaves."""

    age_ms: float
    speed_rad_s: float
    whole: StopFigures


@dataclass(frozen=True, slots=True)
class LimitsReport:
    """Everything; `tool` are rows of what, value and source, `reach_m` is how far the tool gets from an axis."""

    arm: str
    joints: tuple[str, ...]
    reach_m: float
    limits: tuple[LimitRow, ...]
    tool: tuple[Row, ...]
    stops: tuple[StopRow, ...]
    ages: tuple[AgeRow, ...]


def figure(value: float) -> str:
    """A figure in three digits, more before the point."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def limits_report(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> LimitsReport:
    """The report on an arm as it is configured."""
    levers = model.tcp_levers
    return LimitsReport(
        config.robot.model,
        tuple(limits.names),
        max(levers),
        _limit_rows(config, model, limits),
        (_factor_row(config), *tool_rows(config)),
        _stop_rows(limits, levers),
        _age_rows(config, limits, levers),
    )


def _limit_rows(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> tuple[LimitRow, ...]:
    allowed_ms = config.safety.longest_stop_ms
    lower, upper = file_source(model, "lower", model.lower), file_source(model, "upper", model.upper)
    effort = f"{file_source(model, 'effort', model.effort)}; Farhand commands none"
    stops = f"the three above; {allowed_ms:g} are allowed"
    rows = [
        ("lowest_deg", "lowest, deg", np.degrees(limits.lower), _position_source(config, lower)),
        ("highest_deg", "highest, deg", np.degrees(limits.upper), _position_source(config, upper)),
        ("speed_rad_s", "speed, rad/s", limits.velocity, _speed_source(config)),
        ("acceleration_rad_s2", "acceleration, rad/s²", limits.acceleration, _acceleration_source(config, model)),
        ("jerk_rad_s3", "jerk, rad/s³", limits.jerk, _jerk_source(config, model)),
        ("longest_stop_ms", "longest stop, ms", MS * np.array(longest_stops(limits)), stops),
        ("effort_n_m", "effort, N m", model.effort, effort),
    ]
    return tuple(LimitRow(key, name, tuple(values.tolist()), source) for key, name, values, source in rows)


def _times_factor(config: RemoteConfig) -> str:
    """What follows a source where the factor tightens it."""
    factor = config.robot.limits_factor
    return "" if factor == 1 else f" times robot.limits_factor = {factor:g}"


def _factor_row(config: RemoteConfig) -> tuple[str, str, str]:
    return "factor on speed, acceleration and jerk", f"{config.robot.limits_factor:g}", "robot.limits_factor"


def _speed_source(config: RemoteConfig) -> str:
    speed = config.robot.speed
    return (FILE if speed == 1 else f"robot.speed = {speed:g} of {FILE}") + _times_factor(config)


def _position_source(config: RemoteConfig, own: str) -> str:
    robot = config.robot
    tightened = f"robot.position_deg for {', '.join(robot.position_deg)}, else {own}" if robot.position_deg else own
    margin = robot.position_margin_deg
    return f"{tightened}, less robot.position_margin_deg = {margin:g}" if margin else tightened


def _acceleration_source(config: RemoteConfig, model: ArmModel) -> str:
    wanted = np.array(config.robot.acceleration_rad_s2) * np.ones(len(model.joint_names))
    assumed = assumed_in_configuration(model, "acceleration", wanted) or of_another_arm(config.robot)
    return f"robot.acceleration_rad_s2{assumed}{_times_factor(config)}; {_bound(model.acceleration, FILE)}"


def _jerk_source(config: RemoteConfig, model: ArmModel) -> str:
    times, own = _times_factor(config), file_source(model, "jerk", model.jerk)
    if not isinstance(config.robot.jerk_rad_s3, str):
        return f"robot.jerk_rad_s3{times}; {_bound(model.jerk, own)}"
    return (own if not model.without_jerk else f"{UNSTATED_JERK_RAD_S3:g} where {FILE} states none") + times


def _bound(own: Array, source: str) -> str:
    """What the arm's file allows, whose values are of this source."""
    if not np.isfinite(own).all():
        return f"{FILE} states none"
    least, most = figure(own.min()), figure(own.max())
    allowed = least if least == most else f"{least} to {most}"
    return f"{FILE} allows {allowed}" + (f" ({source})" if source != FILE else "")


def _stop_rows(limits: JointLimits, levers: Sequence[float]) -> tuple[StopRow, ...]:
    full = float(limits.velocity.max())
    speeds = [speed for speed in SPEEDS_RAD_S if speed < full] + [full]
    return tuple(
        StopRow(speed, steady_stop(limits, levers, speed), rising_stop(limits, levers, speed)) for speed in speeds
    )


def _age_rows(config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> tuple[AgeRow, ...]:
    """A row for each age limit that can be in force, or for the shortest, the longest and one in between."""
    least, most = AgeLimit(config.safety).range_ns
    ages_ns = sorted({least, min(2 * least, most), most})
    return tuple(_age_row(age_ns, config, limits, levers) for age_ns in ages_ns)


def _age_row(age_ns: int, config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> AgeRow:
    slowed = limits.scaled_speed(speed_scale_at(age_ns))
    full = float(slowed.velocity.max())
    before_s = age_ns / NS_PER_MS / MS + TICKS / config.control.rate_hz
    stop, (by_one_m, by_all_m) = rising_stop(slowed, levers, full), way(slowed, levers, full, before_s)
    whole = StopFigures(before_s + stop.seconds, by_one_m + stop.by_one_m, by_all_m + stop.by_all_m)
    return AgeRow(age_ns / NS_PER_MS, full, whole)
