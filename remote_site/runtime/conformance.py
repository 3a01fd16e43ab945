"""Runs the conformance suite on the configured driver, with the simulated cell or emulated robot it needs."""

import gc
import time
from collections.abc import Callable, Mapping
from functools import partial

import msgspec

from common.errors import InterruptionError
from common.host_clock import MonotonicClock
from common.process.children import READY_TIMEOUT_S, Children, Heartbeat
from common.process.log import start_log
from common.process.service import StopFlag, ask_for_real_time
from remote_site.config import RemoteConfig
from remote_site.drivers.config import ADDRESS_OPTIONS
from remote_site.drivers.conformance.machine_pauses import counts_pauses, machine_pauses
from remote_site.drivers.conformance.suite import verdicts_of
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.conformance.verdicts import Verdict
from remote_site.drivers.registry import DriverHost, create_driver
from remote_site.runtime.app import run_cell_child
from remote_site.runtime.checks import check_driven_arm
from remote_site.runtime.driver_process import FIFO_PRIORITY, setup_of
from remote_site.runtime.emulated_robot import REAL_ROBOT, start_robot, unused_address
from remote_site.simulation.memory import CellMemory

DOZE_S = 0.002
UNCOUNTED = (
    "this kernel does not count how long a thread waits for a processor, so pauses of this machine are the driver's"
)


def test_driver(config: RemoteConfig, report: Callable[[str], None], should_stop: StopFlag) -> Mapping[str, Verdict]:
    """Run every check on the configured driver and report a line each; the verdicts by the checks' names.

    InterruptionError, once the robot rests, when asked to stop.
    """
    start_log("driver test")
    name = config.driver.name
    config, note = _emulated_without_address(config)
    check_driven_arm(config)
    if note:
        report(note)
    if not counts_pauses():
        report(UNCOUNTED)
    children = Children("driver test")
    try:
        stand = _stand(config, children, should_stop)
        ask_for_real_time(FIFO_PRIORITY)  # as the driver's process does
        gc.collect()
        gc.freeze()  # as there: collecting all that was imported takes as long as a call may
        verdicts = verdicts_of(stand, report)
    finally:
        children.end()
    report(f"{name}: {_summary(list(verdicts.values()))}")
    return verdicts


def _emulated_without_address(config: RemoteConfig) -> tuple[RemoteConfig, str]:
    """With the emulated robot where no real one is named, and what to say of it, "" where that was asked."""
    driver = config.driver
    address = ADDRESS_OPTIONS.get(driver.name)
    if driver.emulate:
        unused = unused_address(driver)
        return config, f"the robot is emulated, and {unused} is not used: {REAL_ROBOT}" if unused else ""
    if address is None or driver.options.get(address):
        return config, ""
    emulated = msgspec.structs.replace(config, driver=msgspec.structs.replace(driver, emulate=True))
    return emulated, f"no driver.options.{address} is given, so this is the emulated robot"


def _summary(verdicts: list[Verdict]) -> str:
    failed, repeat = verdicts.count(Verdict.FAILED), verdicts.count(Verdict.REPEAT)
    if not failed and not repeat:
        return "all passed"
    again = f"{repeat} to be repeated, because this machine stood still" if repeat else ""
    return ", ".join(filter(None, (f"{failed} failed" if failed else "none failed", again)))


def _stand(config: RemoteConfig, children: Children, should_stop: StopFlag) -> DriverStand:
    memory = None
    config, clock = start_robot(config, children)
    if config.cell_is_simulated:
        memory = CellMemory.create(len(config.robot.start_deg))
        children.start("cell", partial(run_cell_child, config, memory))
    children.start("probe", _doze)
    children.wait_ready(READY_TIMEOUT_S, should_stop)
    if should_stop():
        raise InterruptionError("interrupted before the robot was moved")
    host = DriverHost(clock, config.driver.options, memory)
    make = partial(create_driver, config.driver.name, host)
    measure_pauses = partial(machine_pauses, children.numbers)
    return DriverStand(clock, setup_of(config), make, config.robot.start, measure_pauses, MonotonicClock(), should_stop)


def _doze(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    """Sleep and wake, as what has ordinary priority on this machine does."""
    while not should_stop():
        heartbeat.beat()
        time.sleep(DOZE_S)
