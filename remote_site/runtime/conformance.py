"""Runs the conformance suite on the configured driver, with the simulated cell or emulated controller it needs."""

from collections.abc import Callable
from functools import partial

import msgspec

from common.clock import MonotonicClock
from common.process.children import READY_TIMEOUT_S, Children
from common.process.log import start_log
from common.process.service import StopFlag, ask_for_real_time
from remote_site.config import RemoteConfig
from remote_site.drivers.config import EMULATED
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.registry import DriverHost, check_driver, create_driver
from remote_site.runtime.app import run_cell_child, start_robot
from remote_site.runtime.driver_process import FIFO_PRIORITY, setup_of
from remote_site.simulation.memory import CellMemory


def test_driver(config: RemoteConfig, report: Callable[[str], None]) -> bool:
    """Run every check on the configured driver and report a line each; whether all passed."""
    start_log("driver test")
    name = config.driver.name
    check_driver(name)
    if name == EMULATED and "port" not in config.driver.options:
        report("no driver.options.port is given, so this is the emulated controller")
        config = msgspec.structs.replace(config, driver=msgspec.structs.replace(config.driver, emulate=True))
    children = Children("driver test")
    try:
        stand = _stand(config, children)
        ask_for_real_time(FIFO_PRIORITY)  # as the driver's process does
        failed = run_checks(stand, report)
    finally:
        children.end()
    report(f"{name}: {len(failed)} failed" if failed else f"{name}: all passed")
    return not failed


def _stand(config: RemoteConfig, children: Children) -> DriverStand:
    clock, memory = MonotonicClock(), None
    config = start_robot(config, children)
    if config.cell_is_simulated:
        memory = CellMemory.create(len(config.robot.start_deg))
        children.start("cell", partial(run_cell_child, config, memory, None))
    children.wait_ready(READY_TIMEOUT_S, StopFlag())
    host = DriverHost(clock, config.driver.options, memory)
    return DriverStand(clock, setup_of(config), lambda: create_driver(config.driver.name, host), config.robot.start)
