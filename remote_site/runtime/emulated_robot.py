"""The robot that a configuration has emulated, in a process of its own: the A465's controller, or an FR3."""

import time
from collections.abc import Mapping

import msgspec

from common.clock import Clock, MonotonicClock
from common.errors import ConfigError
from common.process.children import READY_TIMEOUT_S, Children, Heartbeat
from common.process.service import StopFlag
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c import protocol as c500c_protocol
from remote_site.drivers.config import FRANKA
from remote_site.drivers.franka import robot_limits
from remote_site.drivers.registry import Option

SIMULATED_FOLLOW_MS = 200.0  # its joints go to their setpoints like a spring on a damper, in 0.05 s


def start_robot(config: RemoteConfig, children: Children) -> tuple[RemoteConfig, Clock]:
    """Start the emulated robot if configured; the configuration that names where it is, and the clock that it goes by.

    That of a simulator is slower than this machine's where this machine is too slow for it.
    """
    if not config.driver.emulate:
        return config, MonotonicClock()
    is_franka = config.driver.name == FRANKA
    joints = robot_limits.JOINTS if is_franka else c500c_protocol.JOINTS
    if len(config.robot.start_deg) != joints:
        raise ConfigError(
            f"robot.model {config.robot.model!r} has {len(config.robot.start_deg)} joints, and the robot that is "
            f"emulated for {config.driver.name} has {joints}: give the configuration of that robot"
        )
    start = _start_franka if is_franka else _start_c500c
    options, clock = start(config, children)
    driver = msgspec.structs.replace(config.driver, options=options)
    return msgspec.structs.replace(config, driver=driver), clock


def _start_c500c(config: RemoteConfig, children: Children) -> tuple[Mapping[str, Option], Clock]:
    from remote_site.drivers.c500c.emulation import Emulation, Terminal, run_emulation  # noqa: PLC0415  # as below
    from remote_site.drivers.c500c.emulator import EmulatedController  # noqa: PLC0415  # a real controller needs neither

    terminal = Terminal.create()

    def emulate(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        emulation = Emulation(EmulatedController(config.robot.start), time.monotonic_ns())
        run_emulation(emulation, terminal, should_stop, heartbeat.beat)

    children.start("robot", emulate)
    return dict(config.driver.options) | {"port": terminal.path}, MonotonicClock()


def _start_franka(config: RemoteConfig, children: Children) -> tuple[Mapping[str, Option], Clock]:
    from remote_site.drivers.franka import simulator  # noqa: PLC0415  # a real robot needs none

    simulator.check_installed()
    host, clock = simulator.free_address(), simulator.SimulatedTime()

    def simulate(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        simulator.run_simulator(host, config.robot.start.tolist(), clock, should_stop, heartbeat.beat)

    children.start("robot", simulate)
    children.wait_ready(READY_TIMEOUT_S, StopFlag())  # the driver connects at its start
    given = {"follow_ms": SIMULATED_FOLLOW_MS, **config.driver.options}
    return given | {"host": host, "realtime": False}, clock
