"""The limits of a configured arm with their sources, and what its stops take, as Markdown."""

from collections.abc import Iterable, Sequence

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
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
FILE = "the arm's file"


def limits_report(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> list[str]:
    """The lines of the report."""
    levers, full = model.tcp_levers, float(limits.velocity.max())
    reach = f"{max(levers):.2f} m"
    return [
        f"The limits of the arm {config.robot.model}, joint by joint:",
        "",
        *_limits_table(config, model, limits),
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
    robot, allowed_ms = config.robot, config.safety.longest_stop_ms
    speed = FILE if robot.speed == 1 else f"robot.speed = {robot.speed:g} of {FILE}"
    rows = [
        ("lowest, deg", np.degrees(limits.lower), _position_source(config)),
        ("highest, deg", np.degrees(limits.upper), _position_source(config)),
        ("speed, rad/s", limits.velocity, speed),
        ("acceleration, rad/s²", limits.acceleration, _acceleration_source(model)),
        ("jerk, rad/s³", limits.jerk, _jerk_source(config, model)),
        ("longest stop, ms", MS * np.array(longest_stops(limits)), f"the three above; {allowed_ms:g} are allowed"),
    ]
    head = ["limit", *limits.names, "from"]
    return _table(head, ([name, *map(_figure, values.tolist()), source] for name, values, source in rows))


def _position_source(config: RemoteConfig) -> str:
    robot = config.robot
    tightened = f"robot.position_deg for {', '.join(robot.position_deg)}, else {FILE}" if robot.position_deg else FILE
    margin = robot.position_margin_deg
    return f"{tightened}, less robot.position_margin_deg = {margin:g}" if margin else tightened


def _acceleration_source(model: ArmModel) -> str:
    return f"robot.acceleration_rad_s2; {_bound(model.acceleration)}"


def _jerk_source(config: RemoteConfig, model: ArmModel) -> str:
    own = FILE if not model.without_jerk else f"{UNSTATED_JERK_RAD_S3:g} where {FILE} states none"
    return own if isinstance(config.robot.jerk_rad_s3, str) else f"robot.jerk_rad_s3; {_bound(model.jerk)}"


def _bound(own: Array) -> str:
    """What the arm's file allows."""
    if not np.isfinite(own).all():
        return f"{FILE} states none"
    least, most = _figure(own.min()), _figure(own.max())
    return f"{FILE} allows {least}" if least == most else f"{FILE} allows {least} to {most}"


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
        name = f"{_figure(speed)} rad/s" + (", full speed" if speed == speeds[-1] else "")
        rows.append([name, *_stop(steady_stop(limits, levers, speed)), *_stop(rising_stop(limits, levers, speed))])
    return _table(head, rows)


def _stop(figures: StopFigures) -> tuple[str, str]:
    return f"{MS * figures.seconds:.0f} ms", f"{MM * figures.by_one_m:.0f} mm, {MM * figures.by_all_m:.0f} mm"


def _ages_table(config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> list[str]:
    """A row for each age limit that can be in force, or for the shortest, the longest and one in between."""
    least, most = AgeLimit(config.safety).range_ns
    ages_ns = sorted({least, min(2 * least, most), most})
    head = ["age limit", "greatest joint speed", "rest after", "the tool by one joint, by all"]
    return _table(head, [_age_row(age_ns, config, limits, levers) for age_ns in ages_ns])


def _age_row(age_ns: int, config: RemoteConfig, limits: JointLimits, levers: Sequence[float]) -> list[str]:
    slowed = limits.scaled_speed(speed_scale_at(age_ns))
    full = float(slowed.velocity.max())
    before_s = age_ns / NS_PER_MS / MS + TICKS / config.control.rate_hz
    stop, (by_one_m, by_all_m) = rising_stop(slowed, levers, full), way(slowed, levers, full, before_s)
    whole = StopFigures(before_s + stop.seconds, by_one_m + stop.by_one_m, by_all_m + stop.by_all_m)
    return [f"{age_ns / NS_PER_MS:g} ms", f"{_figure(full)} rad/s", *_stop(whole)]


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows)]


def _figure(value: float) -> str:
    """Three digits, more before the point."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"
