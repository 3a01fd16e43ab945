"""The robot that a configuration has emulated, in a process of its own: the A465's controller, or an FR3."""

import time
from collections.abc import Mapping

import msgspec

from common.clock import Clock
from common.host_clock import MonotonicClock
from common.process.children import READY_TIMEOUT_S, Children, Heartbeat
from common.process.service import StopFlag
from remote_site.config import RemoteConfig
from remote_site.drivers.config import ADDRESS_OPTIONS, FRANKA, DriverConfig
from remote_site.drivers.registry import Option

REAL_ROBOT = "set driver.emulate = false, and leave --emulate out, for the real one"
SIMULATED_FOLLOW_MS = 200.0  # its joints go to their setpoints like a spring on a damper, in 0.05 s


def start_robot(config: RemoteConfig, children: Children) -> tuple[RemoteConfig, Clock]:
    """Start the emulated robot if configured; the configuration that names where it is, and the clock that it goes by.

    That of a simulator is slower than this machine's where this machine is too slow for it.
    """
    if not config.driver.emulate:
        return config, MonotonicClock()
    start = _start_franka if config.driver.name == FRANKA else _start_c500c
    options, clock = start(config, children)
    driver = msgspec.structs.replace(config.driver, options=options)
    return msgspec.structs.replace(config, driver=driver), clock


def unused_address(driver: DriverConfig) -> str:
    """The key and value that say where the real robot is, where one is emulated instead; "" without."""
    name = ADDRESS_OPTIONS.get(driver.name, "")
    address = driver.options.get(name) if driver.emulate else None
    return f"driver.options.{name} = {address!r}" if address else ""


def check_emulator(driver: DriverConfig) -> None:
    """NotInstalledError where a robot is to be emulated by what is not installed."""
    if driver.emulate and driver.name == FRANKA:
        from remote_site.drivers.franka.simulator import check_installed  # noqa: PLC0415  # a real robot needs none

        check_installed()


def options_before_start(driver: DriverConfig) -> Mapping[str, Option]:
    """The options that the driver will be given, as far as they are known."""
    return {**driver.options, ADDRESS_OPTIONS[driver.name]: "emulated"} if driver.emulate else driver.options


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

    host, clock = simulator.free_address(), simulator.SimulatedTime()

    def simulate(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        simulator.run_simulator(host, config.robot.start.tolist(), clock, should_stop, heartbeat.beat)

    children.start("robot", simulate)
    children.wait_ready(READY_TIMEOUT_S, StopFlag())  # the driver connects at its start
    given = {"follow_ms": SIMULATED_FOLLOW_MS, **config.driver.options}
    return given | {"host": host, "realtime": False}, clock
