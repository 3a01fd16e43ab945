"""The limits, tool and payload of a configured arm with their sources, and what its stops take, as Markdown."""

from collections.abc import Sequence

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from farhand.limits.sources import FILE, assumed_in_configuration, file_source, of_another_arm
from farhand.limits.tables import figure, table
from farhand.limits.tool_rows import tool_rows
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import UNSTATED_JERK_RAD_S3
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.safety.stop_bound import longest_stops
from remote_site.safety.stop_figures import StopFigures, rising_stop, steady_stop, way
from remote_site.session.age_limit import AgeLimit, speed_scale_at

MS = MM = 1000.0
SPEEDS_RAD_S = (0.5, 1.0)  # beside full speed
TICKS = 2  # from the tick that finds a sample too old to the first command of the stop that a robot obeys


def limits_report(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> list[str]:
    """The lines of the report."""
    levers, full = model.tcp_levers, float(limits.velocity.max())
    reach = f"{max(levers):.2f} m"
    return [
        f"The limits of the arm {config.robot.model}, joint by joint:",
        "",
        *_limits_table(config, model, limits),
        "",
        "Its tool, and what holds for all joints:",
        "",
        *table(["what", "value", "from"], [_factor_row(config), *tool_rows(config)]),
        "",
        f"A stop takes at most, from a speed that no joint exceeds, with the tool up to {reach} from an axis:",
        "",
        *_stops_table(limits, levers, [speed for speed in SPEEDS_RAD_S if speed < full] + [full]),
        "",
        f"From the exposure of the last good sample to rest, with {TICKS} ticks of control, at most:",
        "",
        *_ages_table(config, limits, levers),
    ]


def _limits_table(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> list[str]:
    allowed_ms = config.safety.longest_stop_ms
    rows = [
        ("lowest, deg", np.degrees(limits.lower), _position_source(config, file_source(model, "lower", model.lower))),
        ("highest, deg", np.degrees(limits.upper), _position_source(config, file_source(model, "upper", model.upper))),
        ("speed, rad/s", limits.velocity, _speed_source(config)),
        ("acceleration, rad/s²", limits.acceleration, _acceleration_source(config, model)),
        ("jerk, rad/s³", limits.jerk, _jerk_source(config, model)),
        ("longest stop, ms", MS * np.array(longest_stops(limits)), f"the three above; {allowed_ms:g} are allowed"),
        ("effort, N m", model.effort, f"{file_source(model, 'effort', model.effort)}; Farhand commands none"),
    ]
    head = ["limit", *limits.names, "from"]
    return table(head, ([name, *map(figure, values.tolist()), source] for name, values, source in rows))


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


def _stops_table(limits: JointLimits, levers: Sequence[float], speeds: Sequence[float]) -> list[str]:
    head = [
        "joint speed",
        "steady",
        "the tool by one joint, by all",
        "still accelerating",
        "the tool by one joint, by all",
    ]
    rows = []
    for speed in speeds:
        name = f"{figure(speed)} rad/s" + (", full speed" if speed == speeds[-1] else "")
        rows.append([name, *_stop(steady_stop(limits, levers, speed)), *_stop(rising_stop(limits, levers, speed))])
    return table(head, rows)


def _stop(figures: StopFigures) -> tuple[str, str]:
    return f"{MS * figures.seconds:.0f} ms", f"{MM * figures.by_one_m:.0f} mm, {MM * figures.by_all_m:.0f} mm"


def _ages_table(config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> list[str]:
    """A row for each age limit that can be in force, or for the shortest, the longest and one in between."""
    least, most = AgeLimit(config.safety).range_ns
    ages_ns = sorted({least, min(2 * least, most), most})
    head = ["age limit", "greatest joint speed", "rest after", "the tool by one joint, by all"]
    return table(head, [_age_row(age_ns, config, limits, levers) for age_ns in ages_ns])


def _age_row(age_ns: int, config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> list[str]:
    slowed = limits.scaled_speed(speed_scale_at(age_ns))
    full = float(slowed.velocity.max())
    before_s = age_ns / NS_PER_MS / MS + TICKS / config.control.rate_hz
    stop, (by_one_m, by_all_m) = rising_stop(slowed, levers, full), way(slowed, levers, full, before_s)
    whole = StopFigures(before_s + stop.seconds, by_one_m + stop.by_one_m, by_all_m + stop.by_all_m)
    return [f"{age_ns / NS_PER_MS:g} ms", f"{figure(full)} rad/s", *_stop(whole)]
