"""Control around an activation: a robot that answers within a tick is commanded from where it was activated."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from common.errors import DriverError
from common.messages.requests import EngagementAction
from common.messages.robot import SITE_ENDED, SessionState
from common.process.log import RefusalLog
from common.process.service import StopFlag
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.drivers.link import DriverLink, RobotReport
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code
from remote_site.runtime import control
from remote_site.runtime.control import ControlLoop, Inbox
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.reporting import Reporter
from remote_site.runtime.request_server import RequestServer
from remote_site.runtime.site_memory import SiteMemory
from remote_site.session.halts import Halts
from remote_site.session.requests import SessionRequest
from tests.remote_site.remote_loop import TICK_NS, RemoteLoop


class QuickRobot(DriverLink):
    """Stopped, and not quite where it was led to; ready immediately when it is activated."""

    def __init__(self, led_to, measured):
        self.sent, self.q, self.written = led_to, measured, []
        self.fault: RobotFault | None = STOPPED

    def read(self):
        zero = np.zeros(len(self.q))
        return RobotReport(1, self.q, zero, None, self.fault, None, JointMotion.at_rest(self.sent), True)

    def activate(self, q0):
        self.sent, self.fault = q0, None

    def write(self, command):
        self.written.append(command)
        return command


class NoReport(Reporter):
    """A reporter that is not read."""

    def __init__(self):
        """Of nothing."""

    def note(self, *_given):
        """Nothing."""

    def publish(self, *_given):
        return 0


class NobodyAsks(RequestServer):
    """A server without requests."""

    def __init__(self):
        """Of nothing."""

    def poll(self, **_named):
        """Nothing."""


class Requests(Inbox):
    """An inbox without samples, in which one request after the other waits, from the second tick on.

    Each is of somebody who was shown the newest of `halts`; `answers` are the replies.
    """

    def __init__(self, operator, actions, *, maintenance=False):
        self._waiting = [None, *(SessionRequest(action, operator, maintenance) for action in actions)]
        self.answers, self.refusals, self.halts = list[Any](), RefusalLog(), Halts()

    def samples(self, _lease, _now_ns):
        """No hand sample."""
        return []

    def requests(self, _now_ns):
        """The next request, if one waits."""
        request = self._waiting.pop(0) if self._waiting else None
        return [(replace(request, seen_ns=self.halts.newest_ns), self.answers.append)] if request else []


def run_control(loop, robot, inbox, ticks):
    """Tick the control loop of a robot."""
    driven, inbox.halts = DrivenPipeline(loop.pipeline, robot), loop.session.halts
    ticking = ControlLoop(driven, loop.leases, inbox, NoReport(), NobodyAsks(), None, SiteMemory())
    for k in range(1, ticks + 1):
        ticking.tick(loop.clock.now_ns() + k * TICK_NS)


def test_an_engagement_wakes_no_robot_that_has_stopped():
    loop = RemoteLoop()
    robot = QuickRobot(loop.config.robot.start, loop.config.robot.start)
    inbox = Requests("operator-7", [EngagementAction.ENGAGE] * 3)
    run_control(loop, robot, inbox, 4)
    assert not any(answer.done for answer in inbox.answers)
    assert robot.fault is STOPPED
    assert robot.written == []


def test_control_that_stumbled_at_rest_wakes_the_robot_again():
    loop = RemoteLoop()
    robot = QuickRobot(loop.config.robot.start, loop.config.robot.start)
    robot.fault = RobotFault(FaultCode.COMMAND_TIMEOUT, "no command for 102 ms")
    run_control(loop, robot, Requests("nobody", []), 3)
    assert len(robot.written) == 2


def test_maintenance_stops_and_resets_without_the_lease_but_never_engages():
    loop = RemoteLoop()
    start = loop.config.robot.start
    actions = [EngagementAction.ENGAGE, EngagementAction.DISENGAGE, EngagementAction.STOP, EngagementAction.RESET]
    inbox = Requests("mechanic", actions, maintenance=True)
    run_control(loop, QuickRobot(start, start), inbox, 5)
    codes = [answer.reason.code.value for answer in inbox.answers]
    assert codes == ["operators_only", "operators_only", "stopped", "reset"]
    assert "stopped by mechanic" in inbox.answers[2].reason.sentence
    assert loop.session.state is SessionState.DISENGAGED


def test_a_robot_that_is_awake_within_a_tick_is_commanded_from_where_it_was_activated():
    loop = RemoteLoop()
    start = loop.config.robot.start
    robot = QuickRobot(start, start + 2e-5)
    inbox = Requests("operator-7", [EngagementAction.RESET], maintenance=True)
    run_control(loop, robot, inbox, 4)
    assert [answer.reason.code.value for answer in inbox.answers] == ["reset"]
    assert len(robot.written) == 2
    assert all((command.q == robot.q).all() for command in robot.written)


class Told(NoReport):
    """A reporter that keeps the states and reasons that it is to publish."""

    def __init__(self):
        self.published = []

    def publish(self, snapshot, *_others):
        self.published.append((snapshot.state, snapshot.reason.sentence))
        return 0


@pytest.mark.parametrize(
    ("end", "published"),
    [
        (SiteMemory.set_ready, []),
        (SiteMemory.set_ending, [(SessionState.DISENGAGED, "the remote site was asked to end")]),
        (
            lambda site: site.set_failure("remote: process video died"),
            [(SessionState.FAULT, "the remote site ends by itself: remote: process video died")],
        ),
    ],
)
def test_the_last_state_says_that_the_site_was_asked_to_end_or_why_it_has_to(end, published):
    loop, reporter, site = RemoteLoop(), Told(), SiteMemory()
    start = loop.config.robot.start
    driven = DrivenPipeline(loop.pipeline, QuickRobot(start, start))
    ticking = ControlLoop(driven, loop.leases, Requests("nobody", []), reporter, NobodyAsks(), None, site)
    ticking.end()
    ticking.tick(loop.clock.now_ns())
    end(site)
    ticking.end()
    assert reporter.published == published


def test_a_cause_too_long_for_a_state_is_cut_off():
    site = SiteMemory()
    site.set_failure("ö" * 1000)
    assert site.failure == "ö" * 180


def test_the_local_site_knows_the_code_of_a_remote_site_that_ends():
    assert Code.SITE_ENDED.value == SITE_ENDED


class AskedRobot(DriverLink):
    """Control's link to a robot of which one report after the other is read; it is ready once it was activated."""

    def __init__(self, *reports):
        self._reports, self.activated = list(reports), []

    def read(self):
        report = self._reports.pop(0) if len(self._reports) > 1 else self._reports[0]
        return report._replace(fault=None) if self.activated else report

    def activate(self, q0):
        self.activated.append(q0)


def test_the_robot_is_activated_only_where_it_has_just_been_measured(monkeypatch):
    monkeypatch.setattr(control, "ACTIVATION_POLL_S", 0.0)
    q, rest = np.full(6, 0.1), JointMotion.at_rest(np.zeros(6))
    unmeasured = RobotReport(0, np.zeros(6), np.zeros(6), None, NOT_ACTIVATED, None, rest, True, oldest_ns=100)
    robot = AskedRobot(
        unmeasured,
        unmeasured._replace(t_ns=5, age_ns=101, q=q + 0.5),
        unmeasured._replace(t_ns=106, age_ns=100, q=q),
    )
    control._activate(robot, StopFlag())
    assert [posture.tolist() for posture in robot.activated] == [q.tolist()]


def test_a_robot_that_is_never_measured_is_named_and_never_activated(monkeypatch):
    monkeypatch.setattr(control, "ACTIVATION_TIMEOUT_S", 0.05)
    misread = RobotFault(FaultCode.NOT_FINITE, "by its reading joint_3 is not finite")
    zero = np.zeros(6)
    robot = AskedRobot(RobotReport(0, zero, zero, None, misread, None, JointMotion.at_rest(zero), True, oldest_ns=100))
    with pytest.raises(DriverError, match="not_finite: by its reading joint_3"):
        control._activate(robot, StopFlag())
    assert not robot.activated
