"""The simulated controller follows, bridges, stops within limits, and moves again only when activated."""

from typing import Any

import numpy as np
import pytest

from common.geometry import Array
from remote_site.simulation.config import ServoConfig
from remote_site.simulation.controller import ControllerFault, SimulatedController, controller_limits
from remote_site.simulation.memory import CellCommand, command_dtype, setup_dtype

DT, STEP_NS = 0.002, 2_000_000
Q0 = np.array([0.0, 0.0, -0.8, 0.0, -0.8, 0.0])
NAMES = tuple(f"joint_{k}" for k in range(1, 7))
LIMITS = controller_limits(ServoConfig(), NAMES, np.full(6, -1.5), np.full(6, 1.5))


class Desk:
    """A controller, its setpoints and a clock moved by hand; every motion is kept."""

    def __init__(self, timeout_ms: float = 100.0) -> None:
        self.controller = SimulatedController(ServoConfig(), LIMITS, Q0)
        self.setup, self.command = np.zeros((), setup_dtype(6)), np.zeros((), command_dtype(6))
        self.setup[()] = (round(timeout_ms * 1e6), 10.0, 100.0, 25.0)
        self.now_ns = 0
        self.lag = np.zeros(6)
        self.motions: list[Any] = []

    def activate(self, q: Array = Q0) -> None:
        self.command["activation"] += 1
        self.command["run"], self.command["q"], self.command["dq"], self.command["ddq"] = True, q, 0, 0
        self.tick()

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            self.now_ns += STEP_NS
            command = CellCommand.of(self.command)
            if self.controller.asked(command):
                self.controller.activate(self.setup, command)
            measured_q = self.controller.motion.q - self.lag
            self.motions.append(self.controller.tick(command, measured_q, self.now_ns, DT))

    def cruise(self, seconds: float, speed: float = 0.5) -> None:
        """Speed up joint 1 smoothly and keep it going, a setpoint every 4 ms."""
        for k in range(int(seconds * 250)):
            t = 0.004 * k
            ramp = min(t / 0.2, 1.0)
            dq = speed * ramp * ramp * (3 - 2 * ramp)
            ddq = speed * 6 * ramp * (1 - ramp) / 0.2
            self.command["seq"] += 1
            self.command["q"][0] += 0.004 * dq if k else 0.0
            self.command["dq"][0], self.command["ddq"][0] = dq, ddq
            self.tick(2)

    def joint_1(self):
        """Position, velocity, acceleration of joint 1 over all ticks."""
        return (np.array([getattr(m, key)[0] for m in self.motions]) for key in ("q", "dq", "ddq"))


def test_a_steady_stream_is_followed_without_lag():
    desk = Desk()
    desk.activate()
    desk.cruise(1.0)
    assert desk.controller.motion.q[0] == pytest.approx(desk.command["q"][0] + 0.5 * DT, abs=1e-3)
    assert desk.controller.motion.dq[0] == pytest.approx(0.5, abs=0.01)


def test_silence_ends_in_a_stop_within_limits_and_stays():
    desk = Desk()
    desk.activate()
    desk.cruise(0.6)
    silent_at = len(desk.motions)
    desk.tick(400)
    _, dq, ddq = desk.joint_1()
    assert np.abs(ddq[silent_at:]).max() <= 10.0 + 1e-9
    assert np.abs(np.diff(ddq[silent_at + 55 :]) / DT).max() <= 100.0 * 1.01
    assert dq[silent_at + 48] == pytest.approx(0.5, abs=0.01)
    assert np.abs(dq[silent_at + 50 + 75 :]).max() == 0.0
    assert desk.controller.fault is ControllerFault.WATCHDOG
    assert desk.controller.resting


def test_what_the_watchdog_stopped_moves_only_after_a_new_activation():
    desk = Desk()
    desk.activate()
    desk.cruise(0.6)
    desk.tick(400)
    rest = desk.controller.motion.q.copy()
    desk.cruise(0.2)
    assert (desk.controller.motion.q == rest).all()
    desk.activate(rest)
    assert desk.controller.active
    assert desk.controller.fault is ControllerFault.NONE
    desk.cruise(0.2)
    assert desk.controller.motion.q[0] > rest[0]


def test_a_short_gap_is_bridged():
    desk = Desk()
    desk.activate()
    desk.cruise(0.6)
    desk.tick(30)
    assert desk.controller.motion.dq[0] == pytest.approx(0.5, abs=0.01)
    assert desk.controller.active


def test_the_driver_can_tighten_the_watchdog_but_not_widen_it():
    for timeout_ms, ticks in ((40.0, 25), (10_000.0, 60)):
        desk = Desk(timeout_ms)
        desk.activate()
        desk.cruise(0.6)
        desk.tick(ticks)
        assert desk.controller.fault is ControllerFault.WATCHDOG


def test_a_jump_is_followed_within_the_acceleration_of_the_robot():
    desk = Desk()
    desk.activate()
    desk.command["q"][0] += 0.3
    for _ in range(400):
        desk.command["seq"] += 1
        desk.tick()
    q, dq, ddq = desk.joint_1()
    assert np.abs(ddq).max() <= ServoConfig().max_acceleration_rad_s2[0] + 1e-9
    assert np.abs(dq).max() <= 2.98
    assert q[-1] == pytest.approx(0.3, abs=1e-3)
    assert q.max() < 0.301


def test_setpoints_beyond_the_joint_limits_are_cut():
    desk = Desk()
    desk.activate()
    desk.command["q"][0] = 3.0
    for _ in range(1500):
        desk.command["seq"] += 1
        desk.tick()
    assert desk.controller.motion.q[0] == pytest.approx(1.5, abs=1e-6)


@pytest.mark.parametrize("key", ["q", "dq", "ddq"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_setpoint_that_is_not_finite_stops_the_arm(key, value):
    desk = Desk()
    desk.activate()
    desk.cruise(0.6)
    desk.command["seq"] += 1
    desk.command[key][3] = value
    desk.tick(200)
    assert desk.controller.fault is ControllerFault.NOT_FINITE
    assert desk.controller.resting
    assert all(np.isfinite(m.q).all() for m in desk.motions)


def test_activation_far_from_the_arm_is_refused():
    desk = Desk()
    desk.activate(Q0 + 0.1)
    assert desk.controller.fault is ControllerFault.APART
    assert not desk.controller.active


def test_activation_waits_until_the_arm_rests():
    desk = Desk()
    desk.activate()
    desk.cruise(0.6)
    desk.command["run"] = False
    desk.tick(3)
    desk.command["run"] = True
    desk.command["activation"] += 1
    desk.tick(3)
    assert not desk.controller.active
    desk.tick(200)
    assert desk.controller.resting or desk.controller.active


def test_a_blocked_arm_holds_where_it_is():
    desk = Desk()
    desk.activate()
    desk.cruise(0.6)
    desk.lag = np.array([0.11, 0, 0, 0, 0, 0])
    held = desk.controller.motion.q[0] - 0.11
    desk.cruise(0.2)
    assert desk.controller.fault is ControllerFault.BLOCKED
    assert desk.controller.resting
    assert desk.controller.motion.q[0] == pytest.approx(held, abs=1e-9)


def test_an_activated_arm_without_setpoints_holds_still():
    desk = Desk()
    desk.activate()
    desk.tick(200)
    assert desk.controller.active
    assert (desk.controller.motion.q == Q0).all()
