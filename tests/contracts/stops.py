"""What a stop takes when commands cease in full motion: setpoints and the robot's own motion, with every driver."""

from dataclasses import dataclass, replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.trial import DriverStand, NoMark
from remote_site.drivers.driver import JointCommand, RobotReading
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.joints import JointMotion
from tests.contracts.driver_stands import CONFIG, SETUP

DT = 0.004


@dataclass(frozen=True)
class Stop:
    """Time in s and travel in rad from the last command to rest, of what was sent and of the robot itself."""

    speed: float
    sent_s: float
    sent_rad: float
    robot_s: float
    robot_rad: float
    behind_rad: float
    beyond_rad: float


def approach(speed: float, jerk: float, *, accelerating: bool) -> list[JointMotion]:
    """Ticks of joint 1 from rest to `speed`, at 10 rad/s² at the end, or without acceleration for a while."""
    n = round(10.0 / (jerk * DT))
    if accelerating:
        hold = max(0, round((speed - n * DT * 5.0) / (10.0 * DT)))
        jerks = [jerk] * n + [0.0] * hold
    else:
        n = min(n, int(np.sqrt(speed / jerk) / DT) + 1)
        hold = max(0, int(np.ceil((speed / (jerk * DT * DT) - n * n) / n)))
        used = speed / (DT * DT * n * (n + hold))
        jerks = [used] * n + [0.0] * hold + [-used] * n + [0.0] * 75
    q, v, a, ticks = 0.0, 0.0, 0.0, []
    for j in jerks:
        q, v, a = q + v * DT + a * DT**2 / 2 + j * DT**3 / 6, v + a * DT + j * DT**2 / 2, a + j * DT
        ticks.append((q, v, a))
    base, e1 = CONFIG.robot.start, np.eye(6)[0]
    return [JointMotion(base + e1 * (q - 1.5), e1 * v, e1 * a) for q, v, a in ticks]


def measured_stop(stand: DriverStand, speed: float, jerk: float, *, accelerating: bool) -> Stop:
    """Run up to the speed, let commands cease, and watch until the robot rests; the stand's robot starts at -1.5."""
    limits = replace(SETUP.limits, acceleration=np.full(6, 10.0), jerk=np.full(6, jerk))
    setup = replace(SETUP, limits=limits, start=stand.start)
    clock, driver = stand.clock, stand.make()
    driver.configure(setup)
    supervisor = DriverSupervisor(driver, setup, clock, NoMark(), GripWatch(GripSettings()))

    def turn(*orders: DriverOrder) -> None:
        clock.sleep_until_ns(clock.now_ns() + 2 * NS_PER_MS)
        supervisor.take(orders, clock.now_ns())
        supervisor.step(clock.now_ns())

    def reading() -> RobotReading:
        assert supervisor.reading is not None
        return supervisor.reading

    def order(seq: int, motion: JointMotion) -> DriverOrder:
        command = JointCommand(seq, clock.now_ns(), motion.q, motion.dq, motion.ddq, GripperCommand.KEEP)
        return DriverOrder(1, True, supervisor.commanded.stop_count, command)

    for _ in range(100):
        turn()
    turn(order(0, JointMotion.at_rest(stand.start)))
    while supervisor.fault is not None:
        turn()
    for seq, motion in enumerate(approach(speed, jerk, accelerating=accelerating), start=1):
        turn(order(seq, motion))
        turn()
    last, begin_ns, robot_at = supervisor.commanded.motion, clock.now_ns() - 2 * NS_PER_MS, reading().q[0]
    sent, robot = [], []
    for _ in range(600):
        turn()
        sent.append((clock.now_ns(), supervisor.commanded.motion.q[0], supervisor.commanded.motion.dq[0]))
        robot.append((reading().t_ns, reading().q[0], reading().dq[0]))
    sent_s, sent_at = _rest(sent, begin_ns)
    robot_s, rest_at = _rest(robot, begin_ns)
    beyond = max(q for _, q, _ in robot) - sent_at
    return Stop(last.dq[0], sent_s, sent_at - last.q[0], robot_s, rest_at - robot_at, last.q[0] - robot_at, beyond)


def _rest(path: list[tuple[int, float, float]], begin_ns: int) -> tuple[float, float]:
    """Seconds until the last motion of more than 2 mrad/s, and where it came to rest."""
    moving = [t for t, _, dq in path if abs(dq) > 2e-3]
    return (max(moving, default=begin_ns) - begin_ns) / NS_PER_S, path[-1][1]
