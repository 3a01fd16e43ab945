"""Nothing engages while the remote site is still starting, in any mode and by any request."""

import pytest

from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.session.config import EngagementMode
from tests.remote_site.session.session_rig import READY, STARTING, SessionRig


@pytest.mark.parametrize("mode", EngagementMode)
def test_nothing_engages_before_the_site_is_ready(mode: EngagementMode) -> None:
    rig = SessionRig(mode=mode)
    rig.frames(40, STARTING)
    rig.frames(40, STARTING, held=True)
    answer = rig.session.request_engage(rig.now_ns, STARTING)
    assert (answer.done, answer.reason.code) == (False, Code.SITE_STARTING)
    assert rig.frames(1, STARTING, held=True).state is SessionState.DISENGAGED
    assert rig.session.readiness(rig.now_ns, STARTING).reason.code is Code.SITE_STARTING


def test_the_automatic_engagement_waits_for_the_site() -> None:
    rig = SessionRig(mode=EngagementMode.AUTOMATIC)
    rig.frames(40, STARTING)
    assert rig.frames(1, READY).state is SessionState.ENGAGED
