"""Automatic engagement: once, never before the site is ready, and only shortly after both sites were ready."""

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.session.config import EngagementMode
from remote_site.session.engagement_intent import AUTOMATIC_NS, AUTOMATIC_WAIT_NS
from remote_site.session.state_machine import Robot
from tests.remote_site.session.session_rig import DEAD, LEASE, READY, SessionRig


def automatic() -> SessionRig:
    """A session that engages by itself."""
    return SessionRig(mode=EngagementMode.AUTOMATIC)


def pass_seconds(rig: SessionRig, seconds: float, robot: Robot = READY) -> None:
    """Time without a hand, ten ticks a second."""
    for _ in np.arange(0, seconds, 0.1):
        rig.wait(100, robot)


def test_a_hand_within_the_minute_engages() -> None:
    rig = automatic()
    pass_seconds(rig, 58)
    assert rig.frames(30).state is SessionState.ENGAGED


@pytest.mark.parametrize("hours", [0.02, 72.0])
def test_the_first_hand_long_after_both_sites_were_ready_engages_nothing(hours: float) -> None:
    rig = automatic()
    rig.wait(4)
    rig.now_ns += round(hours * 3600 * NS_PER_S)
    decision = rig.frames(90)
    assert decision.state is SessionState.DISENGAGED
    assert decision.reason.code is Code.AUTOMATIC_EXPIRED
    assert rig.session.request_engage(rig.now_ns, READY).done
    assert rig.frames(1).state is SessionState.ENGAGED


def test_the_minute_begins_when_robot_and_local_site_are_both_ready() -> None:
    rig = automatic()
    pass_seconds(rig, 90, DEAD)
    rig.session.authorise(None)
    pass_seconds(rig, 90)
    rig.session.authorise(LEASE)
    pass_seconds(rig, 58)
    assert rig.frames(30).state is SessionState.ENGAGED


def test_the_minute_does_not_begin_again() -> None:
    rig = automatic()
    pass_seconds(rig, 40)
    pass_seconds(rig, 10, DEAD)
    pass_seconds(rig, 20)
    assert rig.frames(90).state is SessionState.DISENGAGED


def test_a_local_site_within_ten_minutes_still_has_its_minute() -> None:
    rig = automatic()
    rig.session.authorise(None)
    rig.wait(4)
    rig.now_ns += AUTOMATIC_WAIT_NS
    rig.session.authorise(LEASE)
    pass_seconds(rig, 55)
    assert rig.frames(30).state is SessionState.ENGAGED


def test_no_local_site_for_long_ends_it_too() -> None:
    rig = automatic()
    rig.session.authorise(None)
    rig.wait(4)
    rig.now_ns += AUTOMATIC_WAIT_NS + AUTOMATIC_NS
    rig.session.authorise(LEASE)
    assert rig.frames(90).state is SessionState.DISENGAGED
