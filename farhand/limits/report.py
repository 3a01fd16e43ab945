"""The limits, tool and payload of a configured arm with their sources, and what its stops take; pure."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import GRIPPER, UNSTATED_JERK_RAD_S3, CapsuleConfig, RobotConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ASSUMED, GIVEN, ArmModel
from remote_site.safety.config import SafetyConfig
from remote_site.safety.stop_bound import longest_stops
from remote_site.safety.stop_figures import StopFigures, rising_stop, steady_stop, way
from remote_site.session.age_limit import AgeLimitChoice, speed_scale_at

MS = 1000.0
SPEEDS_RAD_S = (0.5, 1.0)  # beside full speed
TICKS = 2  # from the tick that finds a sample too old to the first command of the stop that a robot obeys
FILE = "the arm's file"
BY_IMPORT = {ASSUMED: "assumed by farhand arm import", GIVEN: "given to farhand arm import"}
MM = 1000.0
Row = tuple[str, str, str]


def tool_rows(config: RemoteConfig) -> list[Row]:
    """List what describes the tool: name, value, and source."""
    robot = config.robot
    x, y, z = (MM * robot.tool_T_tcp[:3, 3]).tolist()
    payload = "not stated" if robot.payload_kg is None else f"{robot.payload_kg:g}"
    return [
        ("tool's frame", robot.tool_frame, "robot.tool_frame"),
        ("tool centre point in it, mm", f"{x:g}, {y:g}, {z:g}", "robot.tool_offset_m, along z"),
        *_capsule_rows(robot),
        ("largest grip force, N", f"{config.grip.force_n:g}", "grip.force_n; the gripper's own may be less"),
        ("payload beyond the tool, kg", payload, "robot.payload_kg; shown only, no limit follows from it"),
        ("box of the tool centre point, m", _box(config.safety), "safety.workspace_min_m, safety.workspace_max_m"),
    ]


def _capsule_rows(robot: RobotConfig) -> list[Row]:
    """A row for each link that carries capsules."""
    if not robot.capsules:
        return [("capsules around the tool", "none: a bare flange", "robot.capsules")]
    source = "robot.capsules" + (_whose(robot) if robot.capsules == GRIPPER else "")
    carried = [(capsule.link or robot.tool_frame, _reach_m(capsule)) for capsule in robot.capsules]
    rows = []
    for link, group in groupby(sorted(carried), key=lambda item: item[0]):
        reaches_m = [reach_m for _, reach_m in group]
        extent = f"{len(reaches_m)}, up to {MM * max(reaches_m):.0f} mm from its origin"
        rows.append((f"capsules on {link}", extent, source))
    return rows


def _whose(robot: RobotConfig) -> str:
    """Of the gripper that counts where none is given, which is the A465's own alone."""
    default = robot.model == RobotConfig().model
    return ", by default the A465's gripper" if default else ", the shape of the A465's gripper: give your own"


def _reach_m(capsule: CapsuleConfig) -> float:
    """Compute how far a capsule extends from the origin of its link, m."""
    return max(math.hypot(*end) for end in (capsule.start_m, capsule.end_m)) + capsule.radius_m


def _box(safety: SafetyConfig) -> str:
    sides = zip("xyz", safety.workspace_min_m, safety.workspace_max_m, strict=True)
    return ", ".join(f"{axis} {low:g} to {high:g}" for axis, low, high in sides)


def file_source(model: ArmModel, key: str, values: Array) -> str:
    """The source of the file's values (n,) of one attribute of its limits."""
    parts = []
    others = list(model.joint_names)
    for mark, words in BY_IMPORT.items():
        names = _unchanged(model, model.marked(mark, key), values)
        others = [name for name in others if name not in names]
        if names:
            parts.append(words if len(names) == len(model.joint_names) else f"{words} for {', '.join(names)}")
    if not parts:
        return FILE
    return "; ".join(parts) + (f"; else {FILE}" if others else "")


def assumed_in_configuration(model: ArmModel, key: str, values: Array) -> str:
    """Return what follows the key of values (n,) that the import assumed in the configuration; else nothing."""
    names = _unchanged(model, model.marked(ASSUMED, key), values)
    if not names:
        return ""
    return f", {BY_IMPORT[ASSUMED]}" + ("" if len(names) == len(model.joint_names) else f" for {', '.join(names)}")


def of_another_arm(robot: RobotConfig) -> str:
    """Return what follows the key of an acceleration that no configuration gives, where the arm is not the A465."""
    default = RobotConfig()
    is_foreign = robot.model != default.model and robot.acceleration_rad_s2 == default.acceleration_rad_s2
    return ", by default the A465's: give your own" if is_foreign else ""


def _unchanged(model: ArmModel, marked: Mapping[str, float], values: Array) -> list[str]:
    """The joints whose value is still the one that it is marked with."""
    stated = zip(model.joint_names, values.tolist(), strict=True)
    return [name for name, value in stated if name in marked and np.isclose(value, marked[name])]


@dataclass(frozen=True, slots=True)
class LimitRow:
    """One limit of every joint: its key for programs, its name for people, the values, where they come from."""

    key: str
    name: str
    values: tuple[float, ...]
    source: str


@dataclass(frozen=True, slots=True)
class StopRow:
    """The figures of a stop from a speed that no joint exceeds: from steady motion, and while still accelerating."""

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
    """Return what follows a source where the factor tightens it."""
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
    """Say what the arm's file allows, whose values are of this source."""
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
    least, most = AgeLimitChoice(config.safety).range_ns
    ages_ns = sorted({least, min(2 * least, most), most})
    return tuple(_age_row(age_ns, config, limits, levers) for age_ns in ages_ns)


def _age_row(age_ns: int, config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> AgeRow:
    slowed = limits.scaled_speed(speed_scale_at(age_ns))
    full = float(slowed.velocity.max())
    before_s = age_ns / NS_PER_MS / MS + TICKS / config.control.rate_hz
    stop, (by_one_m, by_all_m) = rising_stop(slowed, levers, full), way(slowed, levers, full, before_s)
    whole = StopFigures(before_s + stop.seconds, by_one_m + stop.by_one_m, by_all_m + stop.by_all_m)
    return AgeRow(age_ns / NS_PER_MS, full, whole)
