"""Checks before the remote site starts a process: all that its processes load of the arm, and the driver's own."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import structlog

from common.errors import ConfigError, FarhandError, NotInstalledError
from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.drivers.checks_before_start import check_before_start
from remote_site.drivers.config import DriverConfig
from remote_site.drivers.listing import missing_package
from remote_site.drivers.registry import load_factory
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import JointLimits, load_model
from remote_site.kinematics.model import ArmModel
from remote_site.motion.target_tracker import choose_target_tracker
from remote_site.runtime.driver_process import setup_with
from remote_site.runtime.emulated_robot import check_emulator, options_before_start
from remote_site.safety.collision import CollisionModel
from remote_site.safety.stop_bound import check_stops
from remote_site.safety.unguarded import in_one_line, unguarded
from remote_site.safety.workspace_box import check_box
from remote_site.teleop.config import prediction
from remote_site.teleop.mapping import make_mapping
from remote_site.video.streaming.encoding import can_encode
from remote_site.video.streaming.h264 import H264_CURE

DRIVER = "driver"

T = TypeVar("T")


def _raise(mistakes: Sequence["StartupMistake"]) -> None:
    if mistakes:
        raise ConfigError("\n".join(mistake.sentence for mistake in mistakes))


@dataclass(frozen=True, slots=True)
class StartupMistake:
    """The part of the robot's side that cannot be built, why, and which keys cure it."""

    part: str
    sentence: str
    cure: str


@dataclass(frozen=True, slots=True)
class _Loading:
    """Loads part by part, and notes what is wrong instead of ending at the first."""

    mistakes: list[StartupMistake] = field(default_factory=list)

    def load(self, part: str, cure: str, load: Callable[[], T]) -> T | None:
        """The part, or None where it is noted why there is none."""
        try:
            return load()
        except ConfigError as error:
            self.mistakes.extend(StartupMistake(part, line, cure) for line in str(error).splitlines())
        except FarhandError as error:
            self.mistakes.append(StartupMistake(part, " ".join(str(error).split()), cure))
        return None


def check_robot(config: RemoteConfig) -> None:
    """ConfigError with every mistake for which the arm cannot be built, or cannot start at the configured posture."""
    _raise(find_mistakes(config))


def check_driven_arm(config: RemoteConfig) -> None:
    """ConfigError with every mistake for which there is no driver, or it cannot move the configured arm."""
    loading = _Loading()
    _load_driver(config, loading)
    model = _load_model(config.robot, loading)
    limits = _load_limits(model, config.robot, loading) if model is not None else None
    if model is not None and limits is not None:
        _load_start(limits, config.robot, loading)
        _load_setup(model, limits, config, loading)
    _raise(loading.mistakes)


def find_mistakes(config: RemoteConfig) -> list[StartupMistake]:
    """Find what would end a process of the site that loads the arm; parts that need a broken one are not checked."""
    loading = _Loading()
    _load_driver(config, loading)
    loading.load("video", f"{H264_CURE}, or video.codec = 'auto'", lambda: can_encode(config.video.codec))
    loading.load("mapping", "correct the table [mapping]", lambda: make_mapping(config.mapping))
    model = _load_model(config.robot, loading)
    if model is not None:
        _load_with(model, config, loading)
    return loading.mistakes


def find_unguarded(config: RemoteConfig) -> tuple[str, ...]:
    """Find what a configuration without mistakes leaves unguarded, part by part."""
    return unguarded(config.robot, config.safety, load_model(config.robot))


def say_what_is_not_guarded(config: RemoteConfig) -> None:
    """One line of the log, a warning where something is left out that could be guarded."""
    parts, log = find_unguarded(config), structlog.get_logger()
    (log.warning if parts else log.info)("not guarded", what=in_one_line(parts))


def _load_with(model: ArmModel, config: RemoteConfig, loading: _Loading) -> None:
    robot, collision = config.robot, config.safety.collision
    loading.load(
        "collision",
        "correct robot.capsules and [safety.collision], or the URDF's collision elements",
        lambda: CollisionModel.from_urdf(robot.urdf, model, robot.capsules, collision),
    )
    limits = _load_limits(model, robot, loading)
    box = "correct safety.workspace_min_m and _max_m: give the sides where the tool has to stop"
    loading.load("workspace", box, lambda: check_box(config.safety, model))
    if limits is None:
        return
    _load_setup(model, limits, config, loading)
    if _load_start(limits, robot, loading) is None:
        return
    solvers = "correct robot.kinematics, robot.stance and [control.solver]"
    loading.load("kinematics", solvers, lambda: choose_target_tracker(robot, prediction(config), model, limits))
    if config.cell_is_simulated or config.views_are_simulated:
        shown = "correct [simulation], or the URDF of robot.model"
        loading.load("simulated cell", shown, lambda: _build_simulation(config))


def _load_driver(config: RemoteConfig, loading: _Loading) -> None:
    cure = "correct driver.name, or install the package that offers it"
    loading.load(DRIVER, cure, lambda: load_factory(config.driver.name))


def _load_model(robot: RobotConfig, loading: _Loading) -> ArmModel | None:
    return loading.load("robot", "correct robot.model and robot.tool_frame, or that URDF", lambda: load_model(robot))


def _load_limits(model: ArmModel, robot: RobotConfig, loading: _Loading) -> JointLimits | None:
    tighter = "correct robot.position_deg, robot.position_margin_deg, robot.acceleration_rad_s2 and robot.jerk_rad_s3"
    return loading.load("limits", tighter, lambda: JointLimits.from_model(model, robot))


def _load_start(limits: JointLimits, robot: RobotConfig, loading: _Loading) -> Array | None:
    return loading.load("start posture", "correct robot.start_deg", lambda: _start(robot, limits))


def _load_setup(model: ArmModel, limits: JointLimits, config: RemoteConfig, loading: _Loading) -> None:
    """Check how long stops take; where there is a driver, have it check the arm and its options."""
    speed, longest_ms = config.robot.speed, config.safety.longest_stop_ms
    quicker = "correct robot.jerk_rad_s3, robot.acceleration_rad_s2 and robot.speed, or safety.longest_stop_ms"
    loading.load("stopping", quicker, lambda: check_stops(limits, speed, longest_ms))
    if any(mistake.part == DRIVER for mistake in loading.mistakes):
        return
    setup, name = setup_with(config, model, limits), config.driver.name
    loading.load(DRIVER, "install it, or correct driver.name", lambda: _check_packages(config.driver))
    cure = "correct what it names, or give the configuration of that robot"
    loading.load(DRIVER, cure, lambda: check_before_start(name, options_before_start(config.driver), setup))


def _check_packages(driver: DriverConfig) -> None:
    """NotInstalledError where a driver of Farhand's own, or its emulated robot, lacks a package of others."""
    if missing := missing_package(driver.name):
        raise NotInstalledError(missing)
    check_emulator(driver)


def _start(robot: RobotConfig, limits: JointLimits) -> Array:
    """The start posture in rad; ConfigError where the arm has other joints, or may not be there."""
    if len(robot.start_deg) != len(limits.names):
        raise ConfigError(f"robot.start_deg has {len(robot.start_deg)} angles for {len(limits.names)} joints")
    outside = [
        f"robot.start_deg: {name} at {q_deg:g} deg is outside {math.degrees(low):.1f} to {math.degrees(high):.1f} deg"
        for name, q_deg, low, high in zip(limits.names, robot.start_deg, limits.lower, limits.upper, strict=True)
        if not math.degrees(low) <= q_deg <= math.degrees(high)
    ]
    if outside:
        raise ConfigError("\n".join(outside))
    return robot.start


def _build_simulation(config: RemoteConfig) -> None:
    try:
        from remote_site.simulation.cell import build_cell  # noqa: PLC0415  # a real cell needs no MuJoCo
        from remote_site.simulation.process import make_controller  # noqa: PLC0415  # as above
    except ImportError as error:
        cure = "pip install 'farhand[sim]', or choose another driver and give every camera a device or URL"
        raise ConfigError(f"the simulated cell needs MuJoCo ({error}); {cure}") from error
    cell = build_cell(config.simulation, config.robot)
    if config.cell_is_simulated:
        make_controller(cell, config.simulation)
