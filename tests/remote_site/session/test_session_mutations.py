"""Every check of validator, lease and session is needed: with any one taken away, the test named beside it fails."""

import pytest

from common.messages.hand import TrackingStatus
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from remote_site.session import lease as lease_module
from remote_site.session.engagement_intent import EngagementIntent
from remote_site.session.fault_latch import FaultLatch
from remote_site.session.hand_signal import HandSignal
from remote_site.session.lease import LeaseServer
from remote_site.session.state_machine import Session
from remote_site.teleop import sample_validator as intake_module
from remote_site.teleop.pipeline import TeleopPipeline
from remote_site.teleop.sample_validator import SampleValidator
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import RemoteLoop
from tests.remote_site.session import test_fault_latch as of_faults
from tests.remote_site.session import test_lease as of_lease
from tests.remote_site.session import test_state_machine as of_session
from tests.remote_site.teleop import test_certainty as of_certainty
from tests.remote_site.teleop import test_lease_in_pipeline as of_chain
from tests.remote_site.teleop import test_sample_validator as of_intake

NAN = float("nan")


def intake(test, *arguments):
    return lambda: test(SampleValidator(SafetyConfig()), *arguments)


def lease(test, *arguments):
    return lambda: test(LeaseServer(of_lease.LASTS, of_lease.FIRST), *arguments)


def refused(expected):
    """Engaging is refused for this reason."""
    cases = of_session.test_engaging_is_refused_with_the_reason.pytestmark[0].args[1]
    (case,) = (case for case in cases if case[2] is expected)
    return lambda: of_session.test_engaging_is_refused_with_the_reason(*case)


def ended(end):
    """This ends an engagement, and nothing but a request begins another."""
    return lambda: of_session.test_every_end_of_an_engagement_needs_an_explicit_engage(end)


def not_tracked(status, expected):
    test = of_intake.test_a_hand_that_is_not_tracked_is_refused_with_the_trackers_reason
    return intake(test, {"status": status}, expected)


def no_orientation(**changes):
    test = of_intake.test_no_orientation_while_a_tip_is_missing_or_inferred_or_the_hand_is_open
    return intake(test, changes)


def others_move_nothing():
    loop = RemoteLoop()
    loop.run(of_chain.TICKS_PER_SAMPLE * 40, of_chain.swaying)
    assert loop.states[-1] is SessionState.ENGAGED
    of_chain.test_a_second_operators_samples_are_counted_and_change_nothing(loop)


def wrong_robot_latches():
    of_faults.test_what_is_wrong_with_the_robot_itself_is_never_mended(RemoteLoop().session, of_faults.PRESSED)


def stumble_in_motion_stays():
    session = RemoteLoop().session
    assert not FaultLatch(session).note(of_faults.LATE, 0, resting=False)
    assert session.state is SessionState.FAULT


# A condition after `if` that never holds any more.
CONDITIONS = [
    (
        SampleValidator,
        "_time",
        "age_ns < 0",
        intake(of_intake.test_a_sample_from_the_future_is_refused_and_does_not_block_the_next),
    ),
    (
        SampleValidator,
        "_time",
        "age_ns > self._soft_ns",
        intake(of_intake.test_age_counts_from_capture_with_the_offset_and_its_uncertainty),
    ),
    (
        SampleValidator,
        "_time",
        "sample.session == self._session and sample.capture_ns <= self._capture_ns",
        intake(of_intake.test_a_later_number_on_the_same_picture_is_refused),
    ),
    (
        SampleValidator,
        "_judge",
        "certainty.position == 0.0",
        of_certainty.test_a_poor_wrist_holds_the_arm_with_its_reason_and_good_ones_resume,
    ),
    (
        SampleValidator,
        "_judge",
        "not math.isfinite(sum(shown_at))",
        intake(of_intake.test_a_wrist_that_is_not_finite_is_refused, NAN),
    ),
    (
        SampleValidator,
        "_judge",
        "(jump := self._jump(position, sample.capture_ns)) is not None",
        intake(of_intake.test_a_jump_is_refused_and_three_in_a_row_latch),
    ),
    (
        intake_module,
        "clock_offset",
        "age_ns > OFFSET_VALID_NS",
        intake(of_intake.test_a_clock_offset_counts_for_five_seconds),
    ),
    (TeleopPipeline, "_receive", "not isinstance(held, Lease)", others_move_nothing),
    (Session, "tick", "self.state is SessionState.FAULT", of_session.test_a_fault_stays_until_reset),
    (Session, "tick", "not robot.ready", ended(lambda rig: rig.wait(4, of_session.DEAD))),
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
        ended(lambda rig: rig.session.sample(of_session.good(rig.now_ns, new_session=True))),
    ),
    (
        Session,
        "sample",
        "isinstance(result, Rejected) and result.latch and self.state in FOLLOWING",
        ended(lambda rig: rig.session.sample(of_session.JUMPS)),
    ),
    (HandSignal, "take", "result.hand_lost or result.reason.code in CLOCK_TROUBLE", refused(Code.NO_OFFSET)),
    (Session, "authorise", "self.state in FOLLOWING", of_session.test_a_lost_lease_latches_and_names_its_holder),
    (
        Session,
        "_see_intent",
        "held is not None and self._intent.released(held) and self.state in FOLLOWING",
        of_session.test_letting_go_for_a_single_sample_is_a_clutch,
    ),
]
# Any other text, and its replacement.
TEXTS = [
    (Session, "_unready", "self._hand.unfit(now_ns) or ", "", refused(Code.STALE)),
    (Session, "_unready", " or self._hand.collecting(self._engagement.frames)", "", refused(Code.COLLECTING)),
    (
        SampleValidator,
        "_order",
        "sample.seq > self._seq",
        "True",
        intake(of_intake.test_duplicates_and_older_samples_are_refused),
    ),
    (
        SampleValidator,
        "_remember",
        "and sample.session != self._session",
        "and False",
        intake(of_intake.test_a_new_session_is_noticed),
    ),
    (
        SampleValidator,
        "_judge",
        " or sample.status in (TrackingStatus.LOST, TrackingStatus.INITIALISING)",
        "",
        not_tracked(TrackingStatus.LOST, Code.LOST),
    ),
    (
        SampleValidator,
        "_judge",
        " if certainty.orientation else None",
        "",
        intake(of_intake.test_the_orientation_of_tips_that_are_poorly_known_never_acts_however_calm),
    ),
    (intake_module, "_orientation", "or sample.hand_open", "", no_orientation(hand_open=True)),
    (intake_module, "_orientation", "or sample.thumb_inferred", "", no_orientation(thumb_inferred=True)),
    (
        intake_module,
        "clock_offset",
        " or clock.measured_ns > now_ns",
        "",
        intake(of_intake.test_a_clock_offset_from_the_future_of_our_clock_is_none),
    ),
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
        of_session.test_disengaging_before_the_first_engagement_disarms_the_automatic_one,
    ),
    (
        EngagementIntent,
        "lacking",
        "self.input is None or self.hold.held",
        "True",
        of_session.test_an_input_that_was_never_seen_let_go_engages_nothing,
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
