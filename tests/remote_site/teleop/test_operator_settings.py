"""The operator's settings through the whole pipeline: they outlive page and console, and a silent page is a hold."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.messages.hand import Intent, Locks, OperatorSettings, TrackingStatus
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.config import RemoteConfig
from remote_site.reasons import Code
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.teleop.config import MappingConfig
from tests.remote_site.remote_loop import Point, RemoteLoop, assert_within_limits

SAMPLE = 8  # ticks
RISE_M_S = 0.06
MOVED_MM = 0.1  # a straight path between two samples bows in the joints


def settings(loop: RemoteLoop, revision: int = 1, **changes: Any) -> OperatorSettings:
    """What an operator sets under the lease in force."""
    return OperatorSettings(lease=loop.lease, revision=revision, **changes)


def rising(loop: RemoteLoop) -> Callable[[int], Point]:
    """A hand that goes up and to the side from now on."""
    from_ns = loop.clock.now_ns()
    return lambda t_ns: (
        0.0,
        -0.5 * RISE_M_S * (t_ns - from_ns) / NS_PER_S,
        0.3 + RISE_M_S * (t_ns - from_ns) / NS_PER_S,
    )


def still(_t_ns: int) -> Point:
    return 0.0, 0.0, 0.3


def tool(loop: RemoteLoop) -> np.ndarray:
    """Where the commanded tool is, mm in the base's frame."""
    return 1e3 * loop.model.forward(loop.sent.q)[:3, 3]


def locked_loop() -> RemoteLoop:
    """Engaged by an operator whose page has locked z."""
    loop = RemoteLoop()
    loop.run(SAMPLE * 40, still, intent=Intent(settings=settings(loop, locks=Locks(z=True))))
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


@pytest.fixture
def loop() -> RemoteLoop:
    """An arm that follows the hand, its z locked."""
    return locked_loop()


@pytest.mark.parametrize(
    "restarted",
    [
        Intent(),
        Intent(settings=OperatorSettings()),
        Intent(settings=OperatorSettings(lease=41)),
        Intent(settings=OperatorSettings(lease=40, revision=7)),
    ],
)
def test_a_locked_axis_stays_locked_when_the_console_restarts(loop: RemoteLoop, restarted: Intent) -> None:
    assert loop.lease == 41
    before = tool(loop)
    path = rising(loop)
    loop.run(SAMPLE * 10, path, intent=None)
    assert loop.states[-1] is SessionState.HOLDING
    loop.run(SAMPLE * 60, path, intent=restarted)
    assert loop.states[-1] is SessionState.ENGAGED
    moved = tool(loop) - before
    assert moved[0] > 20.0  # it follows the hand to the side
    assert abs(moved[2]) < MOVED_MM
    assert loop.snapshot.settings == settings(loop, locks=Locks(z=True))
    assert_within_limits(loop)


def test_a_silent_page_holds_the_arm_until_it_reports_again(loop: RemoteLoop) -> None:
    path = rising(loop)
    loop.run(SAMPLE * 10, path, intent=Intent())
    loop.run(1, path, intent=None)
    assert (loop.snapshot.state, loop.snapshot.reason.code) == (SessionState.HOLDING, Code.PAGE_SILENT)
    loop.run(SAMPLE * 20, path, intent=None)
    at_rest = loop.sent
    assert at_rest.resting
    loop.run(SAMPLE * 20, path, intent=None)
    assert np.array_equal(loop.sent.q, at_rest.q)
    assert loop.snapshot.reason.code is Code.PAGE_SILENT

    loop.run(SAMPLE * 2, path, intent=Intent())
    assert loop.snapshot.reason.code is Code.COLLECTING  # of resume_frames
    assert np.array_equal(loop.sent.q, at_rest.q)
    loop.run(1, path, intent=Intent())
    assert loop.states[-1] is SessionState.ENGAGED
    assert np.abs(loop.sent.q - at_rest.q).max() < 1e-6  # from new origins: the motion meanwhile is discarded


def test_a_page_that_stays_silent_ends_the_engagement(loop: RemoteLoop) -> None:
    loop.run(SAMPLE * 80, rising(loop), intent=None)
    assert loop.states[-1] is SessionState.DISENGAGED
    at_rest = loop.sent
    loop.run(SAMPLE * 80, rising(loop), intent=Intent())
    assert loop.states[-1] is SessionState.DISENGAGED
    assert np.array_equal(loop.sent.q, at_rest.q)


def test_where_no_page_ever_reported_nothing_holds() -> None:
    loop = RemoteLoop()
    loop.run(SAMPLE * 100, still)
    engaged = loop.states.index(SessionState.ENGAGED)
    assert set(loop.states[engaged:]) == {SessionState.ENGAGED}
    loop.ask(EngagementAction.DISENGAGE)
    loop.run(SAMPLE * 40, still)
    assert loop.ask(EngagementAction.ENGAGE).done
    loop.run(SAMPLE * 20, rising(loop))
    assert loop.states[-1] is SessionState.ENGAGED


def test_with_a_silent_page_nothing_engages_until_the_lease_is_taken_again(loop: RemoteLoop) -> None:
    loop.ask(EngagementAction.DISENGAGE)
    loop.run(SAMPLE * 40, still)
    answer = loop.ask(EngagementAction.ENGAGE)
    assert (answer.done, answer.reason.code) == (False, Code.PAGE_SILENT)
    loop.grant(7)
    loop.run(SAMPLE * 40, still)
    assert loop.snapshot.settings == OperatorSettings(lease=loop.lease)
    assert loop.ask(EngagementAction.ENGAGE).done


def test_with_hold_to_run_a_silent_page_has_let_go() -> None:
    loop = RemoteLoop(RemoteConfig(engagement=EngagementConfig(mode=EngagementMode.HOLD_TO_RUN)))
    loop.run(SAMPLE * 40, still, intent=Intent())
    loop.run(SAMPLE * 2, still, intent=Intent(hold=True))
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(1, still, intent=None)
    assert (loop.snapshot.state, loop.snapshot.reason.code) == (SessionState.DISENGAGED, Code.LET_GO)
    loop.run(SAMPLE * 40, still, intent=None)
    assert loop.snapshot.readiness.done


def test_what_is_set_while_the_hand_is_lost_is_in_force_when_it_is_back(loop: RemoteLoop) -> None:
    both = settings(loop, 2, locks=Locks(x=True, z=True))
    loop.run(SAMPLE * 4, still, status=TrackingStatus.LOST, intent=Intent(settings=both))
    assert loop.snapshot.settings == both
    before = tool(loop)
    loop.run(SAMPLE * 60, rising(loop), intent=Intent())
    assert loop.states[-1] is SessionState.ENGAGED
    assert np.abs(tool(loop) - before)[[0, 2]].max() < MOVED_MM


def test_another_lease_begins_with_the_defaults_and_disengaged(loop: RemoteLoop) -> None:
    loop.grant(8)
    loop.run(SAMPLE * 40, still, session=8)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert loop.snapshot.settings == OperatorSettings(lease=loop.lease)


def test_without_a_page_a_lease_has_settings_of_its_own() -> None:
    loop = RemoteLoop()
    loop.tick()
    assert loop.snapshot.settings == OperatorSettings(lease=loop.lease)


def test_without_a_lease_no_settings_are_in_force(loop: RemoteLoop) -> None:
    held = loop.leases.current(loop.clock.now_ns())
    assert held is not None
    loop.leases.release(held.number, held.holder, loop.clock.now_ns())
    loop.tick()
    assert loop.snapshot.settings is None


@pytest.mark.parametrize(("asked", "given"), [(5.0, 1.25), (0.01, 0.25), (0.5, 0.5)])
def test_the_scale_stays_in_the_configured_range(asked: float, given: float) -> None:
    loop = RemoteLoop(RemoteConfig(mapping=MappingConfig(scale=0.8, scale_range=(0.2, 1.0))))
    loop.run(SAMPLE * 40, still, intent=Intent(settings=settings(loop, scale=asked)))
    assert loop.snapshot.settings == settings(loop, scale=pytest.approx(given))
    before, from_ns = tool(loop), loop.clock.now_ns()
    lift = 0.04
    loop.run(SAMPLE * 100, lambda t_ns: (0.0, 0.0, 0.3 + lift * min((t_ns - from_ns) / NS_PER_S, 1.0)), intent=Intent())
    assert (tool(loop) - before)[2] == pytest.approx(1e3 * lift * 0.8 * given, abs=1.0)


def test_a_scale_outside_its_range_is_refused() -> None:
    with pytest.raises(ValueError, match="must be within scale_range"):
        MappingConfig(scale_range=(0.05, 0.5))
