"""Every check of lease and session is needed: with any one taken away, the test named beside it fails."""

import pytest

from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.session import lease as lease_module
from remote_site.session.engagement_intent import EngagementIntent
from remote_site.session.fault_latch import FaultLatch
from remote_site.session.hand_signal import HandSignal
from remote_site.session.lease import LeaseServer
from remote_site.session.state_machine import Session
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import RemoteLoop
from tests.remote_site.session import session_rig
from tests.remote_site.session import test_engagement as of_engagement
from tests.remote_site.session import test_fault_latch as of_faults
from tests.remote_site.session import test_hold_to_run as of_holding_down
from tests.remote_site.session import test_lease as of_lease
from tests.remote_site.session import test_state_machine as of_session


def lease(test, *arguments):
    return lambda: test(LeaseServer(of_lease.LASTS, of_lease.FIRST), *arguments)


def refused(expected):
    """Engaging is refused for this reason."""
    cases = of_engagement.test_engaging_is_refused_with_the_reason.pytestmark[0].args[1]
    (case,) = (case for case in cases if case[2] is expected)
    return lambda: of_engagement.test_engaging_is_refused_with_the_reason(*case)


def ended(end):
    """This ends an engagement, and nothing but a request begins another."""
    return lambda: of_session.test_every_end_of_an_engagement_needs_an_explicit_engage(end)


def wrong_robot_latches():
    of_faults.test_what_is_wrong_with_the_robot_itself_is_never_mended(RemoteLoop().session, of_faults.PRESSED)


def stumble_in_motion_stays():
    session = RemoteLoop().session
    assert not FaultLatch(session).note(of_faults.LATE, 0, resting=False)
    assert session.state is SessionState.FAULT


# A condition that stands after `if`, and never is so any more.
CONDITIONS = [
    (Session, "tick", "self.state is SessionState.FAULT", of_session.test_a_fault_stays_until_reset),
    (Session, "tick", "not robot.ready", ended(lambda rig: rig.wait(4, session_rig.DEAD))),
    (
        Session,
        "tick",
        "(too_old := self._hand.too_old(now_ns)) is not None",
        of_session.test_age_holds_beyond_soft_and_latches_beyond_latch,
    ),
    (
        Session,
        "tick",
        "paused_ns > self._hand.soft_ns",
        of_session.test_control_that_stood_still_holds_and_catches_nothing_up,
    ),
    (Session, "_engaged", "unfit is not None", of_session.test_age_holds_beyond_soft_and_latches_beyond_latch),
    (
        Session,
        "_engaged",
        "(collecting := self._hand.collecting(self._engagement.resume_frames)) is not None",
        of_session.test_holding_resumes_with_new_origins_after_fresh_frames_at_rest,
    ),
    (
        Session,
        "_engaged",
        "not robot.resting",
        of_session.test_holding_resumes_with_new_origins_after_fresh_frames_at_rest,
    ),
    (Session, "_unready", "self._lease is None", refused(Code.NO_LEASE)),
    (Session, "_unready", "not robot.ready", refused(Code.ROBOT_NOT_READY)),
    (Session, "_unready", "not robot.resting", refused(Code.MOVING)),
    (HandSignal, "unfit", "self._trouble is not None", refused(Code.LOST)),
    (
        Session,
        "sample",
        "result.new_session",
        ended(lambda rig: rig.session.sample(session_rig.good(rig.now_ns, new_session=True))),
    ),
    (
        Session,
        "sample",
        "isinstance(result, Rejected) and result.latch and self.state in FOLLOWING",
        ended(lambda rig: rig.session.sample(session_rig.JUMPS)),
    ),
    (HandSignal, "take", "result.hand_lost or result.reason.code in CLOCK_TROUBLE", refused(Code.NO_OFFSET)),
    (Session, "authorise", "self.state in FOLLOWING", of_session.test_a_lost_lease_latches_and_names_its_holder),
    (
        Session,
        "_see_intent",
        "held is not None and self._intent.released(held) and self.state in FOLLOWING",
        of_holding_down.test_letting_go_for_a_single_sample_is_a_clutch,
    ),
]
# Any other text, and what stands there instead.
TEXTS = [
    (Session, "_unready", "self._hand.unfit(now_ns) or ", "", refused(Code.STALE)),
    (Session, "_unready", " or self._hand.collecting(self._engagement.frames)", "", refused(Code.COLLECTING)),
    (
        LeaseServer,
        "current",
        " and now_ns < self._lease.expires_ns",
        "",
        lease(of_lease.test_it_lasts_five_seconds_from_the_last_renewal_and_not_a_nanosecond_longer),
    ),
    (
        LeaseServer,
        "acquire",
        "if current is None:",
        "if True:",
        lease(of_lease.test_who_asks_first_gets_it_and_the_other_is_refused_with_the_holders_name),
    ),
    (
        lease_module,
        "checked",
        "(number, session) == (current.number, current.holder.session)",
        "session == current.holder.session",
        lease(
            of_lease.test_what_is_sent_under_another_number_or_by_another_site_is_fenced,
            of_lease.FIRST - 1,
            7,
            Code.OLD_LEASE,
        ),
    ),
    (
        lease_module,
        "checked",
        "(number, session) == (current.number, current.holder.session)",
        "number == current.number",
        lease(
            of_lease.test_what_is_sent_under_another_number_or_by_another_site_is_fenced,
            of_lease.FIRST,
            8,
            Code.OLD_LEASE,
        ),
    ),
    (
        LeaseServer,
        "hand_over",
        "if asker is not None",
        "if True",
        lease(of_lease.test_consent_hands_it_to_who_asks_and_to_nobody_else),
    ),
    (
        LeaseServer,
        "asker",
        " and now_ns < self._asked_until_ns",
        "",
        lease(of_lease.test_who_has_not_asked_for_a_while_is_not_handed_it),
    ),
    (
        Session,
        "_barred",
        " else self._stopped",
        " else None",
        of_session.test_a_stop_bars_every_engagement_until_it_is_reset,
    ),
    (
        EngagementIntent,
        "end",
        "self.armed = self.requested = False",
        "pass",
        of_engagement.test_disengaging_before_the_first_engagement_disarms_the_automatic_one,
    ),
    (
        EngagementIntent,
        "lacking",
        "self.input is None or self.hold.held",
        "True",
        of_holding_down.test_an_input_that_was_never_seen_let_go_engages_nothing,
    ),
    (FaultLatch, "_lapses", " and fault.code in SILENCES + ASLEEP", "", wrong_robot_latches),
    (FaultLatch, "_lapses", "resting and ", "", stumble_in_motion_stays),
]
MUTATIONS = [(Mutation(o, f, f"if {c}:", "if False:"), body) for o, f, c, body in CONDITIONS]
MUTATIONS += [(Mutation(o, f, text, instead), body) for o, f, text, instead, body in TEXTS]
IDS = [f"{m.function}: {m.check} -> {m.instead}" for m, _ in MUTATIONS]


@pytest.mark.parametrize(("mutation", "body"), MUTATIONS, ids=IDS)
def test_no_check_before_the_arm_can_be_taken_away(mutation, body, monkeypatch):
    body()
    mutation.apply(monkeypatch)
    with pytest.raises((AssertionError, AttributeError, ValueError)):
        body()
