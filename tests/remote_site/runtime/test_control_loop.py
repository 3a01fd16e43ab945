"""Control around an activation: a robot that answers within a tick is commanded from where it was activated."""

from types import SimpleNamespace

import numpy as np

from common.messages.requests import EngagementAction, EngagementRequest
from common.messages.robot import SessionState
from remote_site.drivers.faults import STOPPED, FaultCode, RobotFault
from remote_site.drivers.link import RobotReport
from remote_site.kinematics.joints import JointMotion
from remote_site.runtime.control import ControlLoop
from tests.remote_site.remote_loop import TICK_NS, RemoteLoop


class QuickRobot:
    """Stopped, and not quite where it was led to; ready at once when it is activated."""

    def __init__(self, led_to, measured):
        self.sent, self.q, self.fault, self.written = led_to, measured, STOPPED, []

    def read(self):
        zero = np.zeros(len(self.q))
        return RobotReport(1, self.q, zero, None, self.fault, None, JointMotion.at_rest(self.sent), True)

    def activate(self, q0):
        self.sent, self.fault = q0, None

    def write(self, command):
        self.written.append(command)
        return command


def test_control_that_stumbled_at_rest_wakes_the_robot_again():
    loop = RemoteLoop()
    robot = QuickRobot(loop.config.robot.start, loop.config.robot.start)
    robot.fault = RobotFault(FaultCode.COMMAND_TIMEOUT, "no command for 102 ms")
    nothing = SimpleNamespace(note=lambda *_: None, publish=lambda *_: None, poll=lambda *_: None, counts={})
    inbox = SimpleNamespace(take=list, engagement=nothing, maintenance=nothing, refusals=nothing)
    control = ControlLoop(loop.chain, robot, nothing, inbox, nothing, None)
    for k in range(1, 4):
        control.tick(loop.clock.now_ns() + k * TICK_NS)
    assert len(robot.written) == 2


def test_maintenance_stops_and_resets_without_the_lease_but_never_engages():
    loop = RemoteLoop()
    start, stopped = loop.config.robot.start, SessionState.DISENGAGED
    robot = QuickRobot(start, start)
    actions = [EngagementAction.ENGAGE, EngagementAction.DISENGAGE, EngagementAction.STOP, EngagementAction.RESET]
    answers = []

    def poll(_now_ns, answer):
        if actions:
            answers.append(answer(EngagementRequest(id=1, deadline_ns=0, operator="mechanic", action=actions.pop(0))))

    nothing = SimpleNamespace(note=lambda *_: None, publish=lambda *_: None, poll=lambda *_: None, counts={})
    maintenance = SimpleNamespace(poll=poll)
    inbox = SimpleNamespace(take=list, engagement=nothing, maintenance=maintenance, refusals=nothing)
    control = ControlLoop(loop.chain, robot, nothing, inbox, nothing, None)
    for k in range(1, 6):
        control.tick(loop.clock.now_ns() + k * TICK_NS)
    assert [answer.code for answer in answers] == ["operators_only", "operators_only", "stopped", "reset"]
    assert "stopped by mechanic" in answers[2].reason
    assert loop.session.state is stopped


def test_a_robot_that_is_awake_within_a_tick_is_commanded_from_where_it_was_activated():
    loop = RemoteLoop()
    start = loop.config.robot.start
    robot = QuickRobot(start, start + 2e-5)
    requests = [EngagementRequest(id=1, deadline_ns=0, operator="operator-7", action=EngagementAction.ENGAGE)]
    answers = []

    def poll(_now_ns, answer):
        while requests:
            answers.append(answer(requests.pop()))

    nothing = SimpleNamespace(note=lambda *_: None, publish=lambda *_: None, poll=lambda *_: None, counts={})
    inbox = SimpleNamespace(take=list, engagement=SimpleNamespace(poll=poll), maintenance=nothing, refusals=nothing)
    control = ControlLoop(loop.chain, robot, nothing, inbox, nothing, None)
    for k in range(1, 4):
        control.tick(loop.clock.now_ns() + k * TICK_NS)
    assert [answer.code for answer in answers] == ["activated"]
    assert len(robot.written) == 2
    assert all((command.q == robot.q).all() for command in robot.written)
