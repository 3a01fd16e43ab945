"""Every check of lease and session is needed: with any one taken away, the test named beside it fails."""

import pytest

from common.messages.clutch_latch import ClutchLatch
from common.messages.hand import ClutchKey, OperatorSettings
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.session import lease as lease_module
from remote_site.session import operator_page as page_module
from remote_site.session.config import EngagementMode
from remote_site.session.engagement_intent import EngagementIntent
from remote_site.session.fault_latch import FaultLatch
from remote_site.session.halts import Halts
from remote_site.session.hand_signal import HandSignal
from remote_site.session.hold import Hold
from remote_site.session.lease import Holder, LeaseServer
from remote_site.session.operator_page import Clutch, OperatorPage
from remote_site.session.requests import RequestHandler
from remote_site.session.state_machine import Session
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import RemoteLoop
from tests.remote_site.session import session_rig
from tests.remote_site.session import test_clutch_held as of_clutch
from tests.remote_site.session import test_engagement as of_engagement
from tests.remote_site.session import test_fault_latch as of_faults
from tests.remote_site.session import test_halts as of_halts
from tests.remote_site.session import test_hold_to_run as of_holding_down
from tests.remote_site.session import test_lease as of_lease
from tests.remote_site.session import test_longest_hold as of_longest_hold
from tests.remote_site.session import test_operator_page as of_page
from tests.remote_site.session import test_site_ready as of_site_ready
from tests.remote_site.session import test_state_machine as of_session
from tests.remote_site.teleop import test_operator_settings as of_settings


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


def stays_locked(*reported):
    return lambda: of_page.test_defaults_older_ones_and_those_of_another_lease_overwrite_nothing(*reported)


def silent_page(test):
    return lambda: test(of_settings.locked_loop())


def release_unseen(silence):
    return lambda: of_clutch.test_a_release_that_nobody_reported_leaves_the_arm_held_and_then_disengaged(
        of_clutch.SILENT[silence]
    )


def restless(case):
    """A hand that moves like this is not followed after the clutch."""
    test = of_clutch.test_a_hand_that_moves_is_not_followed_and_the_engagement_ends_after_the_longest_hold
    return lambda: test(of_clutch.RESTLESS[case])


# A condition that stands after `if`, and never is so any more.
CONDITIONS = [
    (Session, "tick", "self.state is SessionState.FAULT", of_session.test_a_fault_stays_until_reset),
    (
        Hold,
        "too_long",
        "now_ns - self.began_ns >= self._longest_ns",
        lambda: of_longest_hold.test_samples_that_trickle_in_end_the_engagement_after_the_longest_hold(250),
    ),
    (
        Session,
        "_unready",
        "not robot.site_ready",
        lambda: of_site_ready.test_nothing_engages_before_the_site_is_ready(EngagementMode.ON_REQUEST),
    ),
    (Session, "_ended", "not robot.ready", ended(lambda rig: rig.wait(4, session_rig.DEAD))),
    (
        Session,
        "_ended",
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
        "waits is not None",
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
    (HandSignal, "observe", "result.hand_lost or result.reason.code in CLOCK_TROUBLE", refused(Code.NO_OFFSET)),
    (Session, "authorise", "self.state in FOLLOWING", of_session.test_a_lost_lease_latches_and_names_its_holder),
    (
        Session,
        "_see_intent",
        "self._intent.released(held) and self.state in FOLLOWING",
        of_holding_down.test_letting_go_for_a_single_sample_takes_new_origins,
    ),
]
# Any other text, and what stands there instead.
TEXTS = [
    (Session, "_unready", "self._hand.unfit(now_ns) or ", "", refused(Code.STALE)),
    (Session, "_unready", " or self._hand.collecting(self._hand.frames)", "", refused(Code.COLLECTING)),
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
        "(number, client) == (current.number, current.holder)",
        "client == current.holder",
        lease(
            of_lease.test_what_is_sent_under_another_number_or_by_another_site_is_fenced,
            of_lease.FIRST - 1,
            of_lease.ANNA,
            Code.OLD_LEASE,
        ),
    ),
    (
        lease_module,
        "checked",
        "(number, client) == (current.number, current.holder)",
        "number == current.number",
        lease(
            of_lease.test_what_is_sent_under_another_number_or_by_another_site_is_fenced,
            of_lease.FIRST,
            of_lease.BEN,
            Code.NOT_HOLDER,
        ),
    ),
    (
        lease_module,
        "checked",
        "(number, client) == (current.number, current.holder)",
        "(number, client.session) == (current.number, current.holder.session)",
        lease(
            of_lease.test_what_is_sent_under_another_number_or_by_another_site_is_fenced,
            of_lease.FIRST,
            Holder(of_lease.ANNA.session, "ben"),
            Code.NOT_HOLDER,
        ),
    ),
    (
        LeaseServer,
        "acquire",
        "current.holder == asker",
        "current.holder.session == asker.session",
        lease(of_lease.test_another_operator_with_the_holders_session_is_refused),
    ),
    (
        LeaseServer,
        "hand_over",
        "if asker == to",
        "if True",
        lease(of_lease.test_consent_for_somebody_else_hands_nothing_over_and_names_who_asks_now, of_lease.CARL),
    ),
    (
        LeaseServer,
        "hand_over",
        "if asker is None",
        "if False",
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
        "request_engage",
        "self.halts.reason or ",
        "",
        of_session.test_a_stop_bars_every_engagement_until_it_is_reset,
    ),
    (
        RequestHandler,
        "handle",
        "unseen is not None and ",
        "False and ",
        lambda: of_halts.test_a_reset_clears_no_stop_that_came_after_what_its_sender_was_shown(0),
    ),
    (
        RequestHandler,
        "handle",
        " or not self._session.barred",
        "",
        of_halts.test_an_engagement_asked_for_before_a_disengagement_does_not_outlive_it,
    ),
    (
        Halts,
        "unseen",
        "seen_ns == self.newest_ns",
        "seen_ns >= self.newest_ns",
        lambda: of_halts.test_only_the_newest_halt_itself_may_be_named(1),
    ),
    (
        FaultLatch,
        "_pass_on",
        "and session.state is SessionState.FAULT",
        "and False",
        of_halts.test_an_emergency_stop_behind_a_fault_is_named_and_has_to_be_seen,
    ),
    (
        FaultLatch,
        "_stopped_itself",
        "if self._session.barred",
        "if False",
        of_halts.test_a_robot_that_stops_by_itself_behind_a_stop_is_named,
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
    (
        Session,
        "_engaged",
        " or self._page_silence()",
        "",
        silent_page(of_settings.test_a_silent_page_holds_the_arm_until_it_reports_again),
    ),
    (
        Session,
        "sample",
        "self._hand.distrust()",
        "pass",
        silent_page(of_settings.test_a_silent_page_holds_the_arm_until_it_reports_again),
    ),
    (
        Session,
        "_unready",
        " or self._page_silence()",
        "",
        silent_page(of_settings.test_with_a_silent_page_nothing_engages_until_the_lease_is_taken_again),
    ),
    (
        Session,
        "_page_silence",
        " and self._intent.input is None",
        "",
        of_settings.test_with_hold_to_run_a_silent_page_has_let_go,
    ),
    (
        Session,
        "authorise",
        "self.page.begin(lease.number)",
        "pass",
        of_settings.test_without_a_page_a_lease_has_settings_of_its_own,
    ),
    (OperatorSettings, "followed_by", "new.lease == self.lease and ", "", stays_locked(of_page.OTHER_LEASE)),
    (OperatorSettings, "followed_by", " and new.revision > self.revision", "", stays_locked(of_page.AS_GRANTED)),
    (OperatorPage, "begin", "lease != self.settings.lease", "True", of_page.test_a_renewed_lease_keeps_them),
    (
        OperatorPage,
        "begin",
        "self._has_reported = self._reports = False",
        "pass",
        of_page.test_another_lease_begins_with_the_defaults_and_without_a_page,
    ),
    (
        Session,
        "_engaged",
        " or self.page.clutch.reason()",
        "",
        of_clutch.test_the_arm_holds_from_the_first_sample_with_the_clutch_down_for_as_long_as_it_is_held,
    ),
    (
        Session,
        "_unready",
        "self.page.clutch.reason() or ",
        "",
        lambda: of_clutch.test_while_it_is_held_nothing_engages(ClutchKey.DOWN, Code.CLUTCHED),
    ),
    (
        Session,
        "_stop",
        "why.code is Code.CLUTCHED",
        "False",
        of_clutch.test_the_arm_holds_from_the_first_sample_with_the_clutch_down_for_as_long_as_it_is_held,
    ),
    (
        Hold,
        "begin",
        "if not self.clutched",
        "if True",
        of_clutch.test_a_hold_after_a_clutch_is_the_first_of_its_kind_and_one_after_another_hold_is_not,
    ),
    (ClutchLatch, "see", "if is_missed", "if False", release_unseen("the page lost the focus")),
    (ClutchLatch, "interrupt", "self.key = ClutchKey.UNSEEN", "pass", release_unseen("the page reports nothing")),
    (Clutch, "_see", "self._latch.interrupt()", "pass", release_unseen("a single sample without a report")),
    (
        Clutch,
        "_settle",
        "newest.sample.capture_ns < released_ns",
        "False",
        of_clutch.test_what_a_sample_shows_of_the_hand_before_it_was_sent_is_no_calm_after_the_release,
    ),
    (
        Clutch,
        "_settle",
        "newest.born_ns - last.born_ns > gap_ns or ",
        "",
        lambda: of_clutch.test_a_hand_that_is_not_seen_is_not_calm(lambda rig: rig.wait(90)),
    ),
    (Clutch, "_settle", " or _moved(first, newest)", "", restless("to and fro")),
    (page_module, "_moved", "return before is not now", "return False", restless("turning too fast to be shown")),
    (page_module, "_moved", "angle_between(before, now) > CALM_RAD", "False", restless("turning")),
    (
        page_module,
        "_moved",
        "first.sample.hand_open != newest.sample.hand_open",
        "False",
        restless("opening and closing"),
    ),
    (OperatorPage, "begin", "self.clutch = Clutch()", "pass", of_clutch.test_a_new_lease_begins_with_the_clutch_up),
    (FaultLatch, "_lapses", " and fault.code in SILENCES + ASLEEP", "", wrong_robot_latches),
    (FaultLatch, "_lapses", "resting and ", "", stumble_in_motion_stays),
]
MUTATIONS = [(Mutation(o, f, f"if {c}:", "if False:"), body) for o, f, c, body in CONDITIONS]
MUTATIONS += [(Mutation(o, f, text, instead), body) for o, f, text, instead, body in TEXTS]
IDS = [f"{m.function}: {m.check} -> {m.instead}" for m, _ in MUTATIONS]


@pytest.mark.slow
@pytest.mark.parametrize(("mutation", "body"), MUTATIONS, ids=IDS)
def test_no_check_before_the_arm_can_be_taken_away(mutation, body, monkeypatch):
    body()
    mutation.apply(monkeypatch)
    with pytest.raises((AssertionError, AttributeError, ValueError)):
        body()
