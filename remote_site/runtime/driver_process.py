"""The process of the robot's driver: orders in, reports out, and the stop when control is gone."""

import gc
import math

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.host_clock import MonotonicClock
from common.process.children import Heartbeat
from common.process.service import StopFlag, ask_for_real_time
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.faults import STOPPED
from remote_site.drivers.memory import MOTION_ROWS, DriverMemory, DriverReport
from remote_site.drivers.registry import DriverHost, create_driver
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.limits import JointLimits, JointRange, load_arm
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.transition_log import FaultLog
from remote_site.safety.stop_bound import check_stops
from remote_site.simulation.memory import CellMemory

FIFO_PRIORITY = 45  # below control, above the simulated cell
WAKES_PER_TICK = 2
END_NS = NS_PER_S
HELD_FRACTION = 0.1  # of the largest grip force: a gripper at rest that measures more holds an object


def run_driver(
    config: RemoteConfig,
    memory: DriverMemory,
    cell: CellMemory | None,
    should_stop: StopFlag,
    heartbeat: Heartbeat,
) -> None:
    """Drive the robot until asked to end; then stop it, and deactivate its driver once it rests."""
    clock = MonotonicClock()
    setup = setup_of(config)
    driver = create_driver(config.driver.name, DriverHost(clock, config.driver.options, cell))
    joints = driver.capabilities.joints
    if joints not in (None, len(setup.joint_names)):
        raise DriverError(
            f"the driver {config.driver.name!r} moves {joints} joints, the model has {len(setup.joint_names)}"
        )
    driver.configure(setup)
    supervisor = DriverSupervisor(driver, setup, clock, memory.busy, GripWatch(grip_settings(config)))
    loop = DriverLoop(supervisor, memory, clock)
    ask_for_real_time(FIFO_PRIORITY)
    gc.collect()
    gc.freeze()
    longest_ns = round(setup.dt * NS_PER_S / WAKES_PER_TICK)
    try:
        while not should_stop():
            loop.wait(longest_ns)
            loop.turn()
            heartbeat.beat()
    except BaseException:
        driver.stop()  # whatever failed here, the robot is not left to itself
        raise
    end_ns = clock.now_ns() + END_NS
    supervisor.stop(STOPPED, clock.now_ns())
    while not supervisor.settled and clock.now_ns() < end_ns:
        loop.wait(longest_ns)
        loop.turn()
    driver.deactivate()


def setup_of(config: RemoteConfig) -> DriverSetup:
    """Build the setup of every driver; ConfigError where its stops could take longer than configured."""
    model, limits = load_arm(config.robot)
    check_stops(limits, config.robot.speed, config.safety.longest_stop_ms)
    return setup_with(config, model, limits)


def setup_with(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> DriverSetup:
    """The same with an arm that is loaded already, and whose stops are short enough."""
    return DriverSetup(
        joint_names=model.joint_names,
        limits=limits,
        dt=1.0 / config.control.rate_hz,
        command_timeout_ns=round(config.driver.command_timeout_ms * NS_PER_MS),
        grip_force_n=config.grip.force_n,
        start=config.robot.start,
        own_range=JointRange(model.lower, model.upper, model.velocity),
    )


def grip_settings(config: RemoteConfig) -> GripSettings:
    """Build the settings by which a gripper is closed, open, or late."""
    grip = config.grip
    return GripSettings(
        grip.closed_mm / 1000, grip.open_mm / 1000, round(grip.timeout_ms * NS_PER_MS), grip.force_n * HELD_FRACTION
    )


class DriverLoop:
    """Orders from the memory to the supervisor, its report to the memory, one turn after the other."""

    def __init__(self, supervisor: DriverSupervisor, memory: DriverMemory, clock: Clock) -> None:
        self._supervisor, self._memory, self._clock = supervisor, memory, clock
        self._motions = np.zeros((MOTION_ROWS, len(supervisor.commanded.motion.q)))
        self._log = FaultLog()

    def wait(self, longest_ns: int) -> None:
        """Wait for an order, until the supervisor has something to write, or for `longest_ns`."""
        due_ns = self._supervisor.due_ns
        wait_ns = longest_ns if due_ns is None else min(max(due_ns - self._clock.now_ns(), 0), longest_ns)
        self._memory.bell.wait(wait_ns / NS_PER_S)

    def turn(self) -> None:
        """Take what has been ordered, drive, and report."""
        now_ns = self._clock.now_ns()
        self._supervisor.take(self._memory.orders.take(), now_ns)
        self._supervisor.step(now_ns)
        self._report()
        self._log.note(self._supervisor.fault)

    def _report(self) -> None:
        supervisor, motions = self._supervisor, self._motions
        fault, reading, gripper = supervisor.fault, supervisor.reading, supervisor.grip.state
        if reading is not None:
            motions[0], motions[1] = reading.q, reading.dq
        stop = supervisor.commanded.stop
        motion = supervisor.commanded.motion if stop is None else stop.motion
        motions[2], motions[3], motions[4] = motion.q, motion.dq, motion.ddq
        written = supervisor.written
        motions[5], motions[6], motions[7] = written.q, written.dq, written.ddq
        self._memory.report.write(
            DriverReport(
                at_ns=self._clock.now_ns(),
                activation=supervisor.activation,
                stop_count=supervisor.commanded.stop_count,
                onset_ns=0 if stop is None else stop.onset_ns,
                t_ns=reading.t_ns if reading is not None else 0,
                oldest_ns=supervisor.oldest_ns,
                has_obeyed=supervisor.obeyed.seq is not None,
                obeyed_seq=supervisor.obeyed.seq or 0,
                opening_m=gripper.opening if gripper is not None else 0.0,
                force_n=gripper.force if gripper is not None and gripper.force is not None else math.nan,
                gripper=gripper.commanded.value.encode() if gripper is not None else b"",
                grip=gripper.status.value.encode() if gripper is not None else b"",
                code=fault.code.value.encode() if fault is not None else b"",
                native=fault.native if fault is not None else "",
                sentence=fault.sentence if fault is not None else "",
                written_seq=written.seq,
                written_ns=written.t_ns,
                motions=motions,
            )
        )
