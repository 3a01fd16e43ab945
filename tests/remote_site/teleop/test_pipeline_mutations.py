"""Every check of validator and pipeline is needed: with any one taken away, the test named beside it fails."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.messages.hand import HandPoint, TrackingStatus
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.safety.config import SafetyConfig
from remote_site.session.hand_signal import HandSignal
from remote_site.session.state_machine import Session
from remote_site.teleop import sample_validator as validator_module
from remote_site.teleop.sample_receiver import SampleReceiver
from remote_site.teleop.sample_validator import SampleValidator
from tests.remote_site.mutation import Mutation
from tests.remote_site.remote_loop import RemoteLoop, hand
from tests.remote_site.teleop import test_certainty as of_certainty
from tests.remote_site.teleop import test_lease_in_pipeline as of_lease
from tests.remote_site.teleop import test_sample_validator as of_validator

NAN = float("nan")


def validator(test, *arguments):
    return lambda: test(SampleValidator(SafetyConfig()), *arguments)


def not_tracked(status, expected):
    test = of_validator.test_a_hand_that_is_not_tracked_is_refused_with_the_trackers_reason
    return validator(test, {"status": status}, expected)


def no_orientation(**changes):
    test = of_validator.test_no_orientation_while_a_tip_is_missing_or_inferred_blindly_or_the_hand_is_open
    return validator(test, changes)


def others_move_nothing():
    loop = RemoteLoop()
    loop.run(of_lease.TICKS_PER_SAMPLE * 40, of_lease.swaying)
    assert loop.states[-1] is SessionState.ENGAGED
    of_lease.test_a_second_operators_samples_are_counted_and_change_nothing(loop)


# A condition that stands after `if`, and never is so any more.
CONDITIONS = [
    (
        SampleValidator,
        "_time",
        "age_ns < 0",
        validator(of_validator.test_a_sample_from_the_future_is_refused_and_does_not_block_the_next),
    ),
    (
        SampleValidator,
        "_time",
        "age_ns > soft_ns",
        validator(of_validator.test_age_counts_from_capture_with_the_offset_and_its_uncertainty),
    ),
    (
        validator_module,
        "_repeated",
        "sample.seq == newest.seq",
        validator(of_validator.test_duplicates_and_older_samples_are_refused),
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
        validator(of_validator.test_a_wrist_that_is_not_finite_is_refused, NAN),
    ),
    (
        SampleValidator,
        "_judge",
        "(jump := self._jump(position, sample.capture_ns)) is not None",
        validator(of_validator.test_a_jump_is_refused_and_three_in_a_row_latch),
    ),
    (
        validator_module,
        "clock_offset",
        "age_ns > OFFSET_VALID_NS",
        validator(of_validator.test_a_clock_offset_counts_for_five_seconds),
    ),
    (SampleReceiver, "receive", "not isinstance(held, Lease)", others_move_nothing),
]
# Any other text, and what stands there instead.
TEXTS = [
    (
        SampleValidator,
        "_time",
        "sample.capture_ns <= newest.capture_ns",
        "False",
        validator(of_validator.test_duplicates_and_older_samples_are_refused),
    ),
    (
        SampleValidator,
        "_remember",
        "and sample.session != self._newest.session",
        "and False",
        validator(of_validator.test_a_new_session_is_noticed),
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
        "shown if any(speeds) else None",
        "shown",
        validator(of_validator.test_the_orientation_of_tips_that_are_poorly_known_never_acts_however_calm),
    ),
    (
        SampleValidator,
        "_judge",
        "certainty_of(sample.covariance, self._point",
        "certainty_of(sample.covariance, HandPoint.WRIST",
        lambda: of_validator.test_the_point_that_the_tool_copies_is_judged_by_its_own_covariance(HandPoint.PALM),
    ),
    (
        SampleValidator,
        "_judge",
        "sample.elbow if elbow_is_certain(sample.covariance, self._config.certainty) else None",
        "sample.elbow",
        lambda: of_validator.test_an_elbow_whose_direction_is_poorly_known_is_not_commanded("elbow"),
    ),
    (validator_module, "shown_orientation", "or sample.hand_open", "", no_orientation(hand_open=True)),
    (
        validator_module,
        "shown_orientation",
        "sample.thumb_inferred and not _tells_covariances(sample)",
        "False",
        no_orientation(thumb_inferred=True),
    ),
    (
        validator_module,
        "clock_offset",
        " or clock.measured_ns > now_ns",
        "",
        validator(of_validator.test_a_clock_offset_from_the_future_of_our_clock_is_none),
    ),
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


def still(_t_ns):
    return (0.0, 0.0, 0.3)


def swaying(t_ns):
    t = t_ns / 1e9
    return (0.1 * np.sin(2.5 * t), 0.05 * np.sin(4 * t), 0.3 + 0.08 * np.sin(3 * t))


def engaged(motion=still):
    loop = RemoteLoop()
    loop.run(8 * 31, motion)
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


def silence_holds():
    loop = engaged(swaying)
    loop.run(60)
    assert loop.states[-1] is SessionState.HOLDING


def a_link_regained_does_not_resume():
    loop = engaged(swaying)
    loop.run(200)
    at_rest = loop.sent.q.copy()
    loop.run(500, swaying)
    assert np.array_equal(loop.sent.q, at_rest)


def a_jump_moves_nothing():
    loop = engaged()
    start = loop.sent.q.copy()
    loop.run(16, lambda _t_ns: (0.4, 0.0, 0.3))
    loop.run(100)
    assert np.abs(loop.sent.q - start).max() < 1e-6


def a_late_sample_is_not_taken():
    loop = engaged()
    late = hand(5000, loop.newest.sample.capture_ns + NS_PER_MS)
    while loop.clock.now_ns() < late.capture_ns + 150 * NS_PER_MS:
        loop.tick()
    loop.tick(late)
    assert loop.snapshot.rejected[Code.STALE] == 1


def an_older_sample_is_not_taken():
    loop = engaged()
    before = loop.newest
    loop.tick(hand(before.sample.seq - 3, before.sample.capture_ns - NS_PER_MS, (0.05, 0.0, 0.3)))
    assert loop.snapshot.rejected == {Code.OLD: 1}
    assert loop.newest is before


def staying_armed(self, why):
    self.state, self._reason, self._intent.armed = SessionState.DISENGAGED, why, True


SESSION = [
    (HandSignal, "unfit", lambda *_: None, silence_holds),
    (Session, "_leave", staying_armed, a_link_regained_does_not_resume),
    (SampleValidator, "_jump", lambda *_: None, a_jump_moves_nothing),
    (SampleValidator, "_time", lambda *_: None, a_late_sample_is_not_taken),
    (SampleValidator, "_time", lambda *_: None, an_older_sample_is_not_taken),
]


@pytest.mark.parametrize(("owner", "check", "instead", "body"), SESSION, ids=[body.__name__ for *_, body in SESSION])
def test_no_check_of_intake_and_session_can_be_taken_away(owner, check, instead, body, monkeypatch):
    body()
    monkeypatch.setattr(owner, check, instead)
    with pytest.raises(AssertionError):
        body()
