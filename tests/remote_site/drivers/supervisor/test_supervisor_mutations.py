"""Every check of the supervisor is needed: with any one taken away, the test named beside it fails."""

from collections.abc import Callable

import pytest

from remote_site.drivers.faults import FaultCode
from remote_site.drivers.supervisor.commanded_motion import CommandedMotion
from remote_site.drivers.supervisor.following_check import FollowingCheck
from remote_site.drivers.supervisor.orders import CommandWatchdog
from remote_site.drivers.supervisor.reading_check import ReadingCheck
from remote_site.drivers.supervisor.state import SupervisorState
from remote_site.drivers.supervisor.stop_plan import StopPlan
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.drivers.supervisor.watched_driver import WatchedDriver
from remote_site.drivers.supervisor.write_scheduler import WriteScheduler
from remote_site.drivers.supervisor.writer import PacedWriter
from tests.remote_site.drivers.supervisor import (
    test_activation,
    test_faults,
    test_following_check,
    test_hand_over,
    test_reading_check,
    test_stop,
    test_stumbling_control,
    test_transitions,
    test_writing,
)
from tests.remote_site.drivers.supervisor.supervised import Supervised
from tests.remote_site.drivers.supervisor.transition_table import ROWS
from tests.remote_site.mutation import Mutation
from tests.remote_site.spoiled_readings import SPOILED

Body = Callable[[], object]
S = SupervisorState


def rig(test: Callable[..., object], *arguments: object) -> Body:
    return lambda: test(Supervised(), *arguments)


def row(name: str, state: SupervisorState) -> Body:
    found = next(each for each in ROWS if each.name == name)
    return lambda: test_transitions.test_every_row_of_the_table_is_what_the_supervisor_does(found, state)


IN_SILENCE = rig(test_stop.test_silence_begins_the_verified_stop_after_three_ticks_and_latches_at_the_time_out)
BY_DEADLINE = rig(test_faults.test_a_call_beyond_the_deadline_is_a_fault_and_visible_while_it_lasts)
MIRRORED = test_faults.test_a_fault_of_the_robot_is_mirrored_and_stays_when_the_robot_clears_it
FAR_PAST = test_hand_over.test_a_stop_written_far_past_the_command_goes_on
AT_REST, ARM_MOVES = row("late_rest", S.FOLLOWING), row("arm_moves", S.HELD)
FIRST_FAULT = rig(test_faults.test_the_first_fault_is_kept)
SLOW_STOP = test_stop.test_a_slow_robot_is_led_to_rest_before_it_is_held
HARDLY_BEGUN = rig(test_stop.test_an_arm_that_has_hardly_begun_is_led_to_rest_before_it_is_held)
SLOW_PATH = test_writing.test_a_slow_robot_gets_setpoints_along_the_path_at_its_rate_and_none_beyond_the_goal
KEPT_AT_REST = test_writing.test_an_arm_kept_at_rest_starts_no_sooner_than_its_jerk_allows
PAST = test_hand_over.test_a_stop_written_a_little_past_the_command_that_ends_it_is_not_taken_back
LATE_DRIVER = test_stumbling_control.test_after_a_late_driver_the_robot_sees_no_more_than_the_limits_by_the_clock
AS_DECLARED = test_following_check.test_an_arm_that_follows_within_its_lag_is_no_fault
AGED = test_reading_check.test_a_reading_ages_from_its_own_stamp_and_a_slow_robots_later
KEPT_ARRAYS = test_reading_check.test_what_the_driver_does_to_its_arrays_later_changes_nothing
SUSPECTED = test_following_check.test_a_joint_may_be_off_by_the_tolerance_and_no_more_for_long
CLEARED = test_following_check.test_one_reading_that_is_right_again_ends_the_suspicion
OUTDATED = test_following_check.test_what_was_written_before_the_lag_no_longer_counts


def spoiled(what: str) -> Body:
    spoil, code = SPOILED[what]
    return lambda: test_reading_check.test_a_bad_reading_is_a_fault_and_never_the_supervisors(spoil, code, driven=True)


CHECKS: list[tuple[object, str, str, str, Body]] = [
    (
        CommandedMotion,
        "obey",
        "if isinstance(verdict, Refused):",
        "if False:",
        rig(test_faults.test_a_command_beyond_the_limits_never_reaches_the_robot_and_ends_in_the_stop, 0.5),
    ),
    (CommandedMotion, "obey", "self.stop_count += 1", "pass", row("missed", S.BRAKING)),
    (CommandedMotion, "begin_stop", "self.stop or StopPlan", "StopPlan", row("too_early", S.BRAKING)),
    (StopPlan, "hands_over_to", "guard.same(command.motion, self.at(command.t_ns))", "True", row("missed", S.BRAKING)),
    (StopPlan, "hands_over_to", " and in_time", "", rig(FAR_PAST, 1.1)),
    (CommandWatchdog, "late", "now_ns - command_ns > self._grace_ns", "False", IN_SILENCE),
    (
        CommandWatchdog,
        "silent_ns",
        "self._silence.of(max(command_ns or 0, self._order_ns), now_ns)",
        "now_ns - max(command_ns or 0, self._order_ns)",
        rig(test_stop.test_a_pause_of_the_drivers_process_itself_is_no_silence_of_control),
    ),
    (CommandWatchdog, "note_order", "self._order_ns = now_ns", "pass", row("outdated", S.BRAKING)),
    (DriverSupervisor, "_watch", "if silent_ns > limit_ns:", "if False:", IN_SILENCE),
    (
        DriverSupervisor,
        "_watch",
        "elif late and self.commanded.motion.resting:",
        "elif False:",
        AT_REST,
    ),
    (DriverSupervisor, "_watch", "elif late and self.state is SupervisorState.FOLLOWING:", "elif False:", IN_SILENCE),
    (
        DriverSupervisor,
        "take",
        "if order.stop_count == self.commanded.stop_count:",
        "if True:",
        rig(test_hand_over.test_a_command_planned_before_the_stop_began_is_ignored),
    ),
    (
        DriverSupervisor,
        "take",
        "elif self.state in ACTIVE and not order.run:",
        "elif False:",
        rig(test_stop.test_an_order_to_stop_stops_and_later_commands_are_ignored),
    ),
    (
        DriverSupervisor,
        "take",
        "elif self.state in ACTIVE:",
        "else:",
        row("waits", S.ACTIVATING),
    ),
    (DriverSupervisor, "stop", "if self.state in ACTIVE:", "if True:", ARM_MOVES),
    (
        DriverSupervisor,
        "_activate",
        "STILL_MOVING if self.state in DRIVEN else self._unfit(q0)",
        "self._unfit(q0)",
        rig(test_activation.test_an_activation_of_an_active_robot_at_rest_stops_it),
    ),
    (
        DriverSupervisor,
        "_unfit",
        "if reading.moving:",
        "if False:",
        ARM_MOVES,
    ),
    (ReadingCheck, "_impossible", "allowed[0] <= value <= allowed[1]", "True", spoiled("a speed is NaN")),
    (
        ReadingCheck,
        "_impossible",
        "OPENING_M[0] <= grip.opening_m <= OPENING_M[1]",
        "True",
        spoiled("the opening is NaN"),
    ),
    (ReadingCheck, "_impossible", "-FORCE_N <= grip.force_n <= FORCE_N", "True", spoiled("the force is NaN")),
    (ReadingCheck, "_mistimed", "if t_ns > now_ns:", "if False:", spoiled("the stamp is of the future")),
    (ReadingCheck, "_mistimed", " or t_ns < self._newest_ns", "", spoiled("the stamp goes back")),
    (ReadingCheck, "_mistimed", "if age_ns > self.oldest_ns", "if False", lambda: AGED(15.0)),
    (ReadingCheck, "judge", "self._newest_ns = t_ns", "pass", spoiled("the stamp goes back")),
    (
        ReadingCheck,
        "judge",
        " or self._jumped(reading.q, t_ns, unseen_ns)",
        "",
        spoiled("a joint has jumped within its range"),
    ),
    (
        ReadingCheck,
        "judge",
        "self._motion.note(reading.q, t_ns, unseen_ns)",
        "pass",
        spoiled("a joint has jumped within its range"),
    ),
    (ReadingCheck, "judge", "np.array(reading.q, dtype=float)", "reading.q", KEPT_ARRAYS),
    (FollowingCheck, "judge", "if self.excess(q).max() <= TOLERANCE_RAD:", "if True:", lambda: SUSPECTED(0.101)),
    (FollowingCheck, "judge", "if now_ns - self._apart_ns < PATIENCE_NS:", "if False:", lambda: SUSPECTED(0.101)),
    (FollowingCheck, "judge", "self._apart_ns = None", "pass", CLEARED),
    (FollowingCheck, "note", "self._written.popleft()", "break", OUTDATED),
    (DriverSupervisor, "_unfit", "if isinstance(reading, RobotFault):", "if False:", row("unread", S.HELD)),
    (DriverSupervisor, "_unfit", "return self._apart(q0, reading.q)", "return None", row("elsewhere", S.HELD)),
    (DriverSupervisor, "_apart", "<= APART_RAD", "<= 9.9", row("elsewhere", S.HELD)),
    (DriverSupervisor, "_activate", "if refused is not None and", "if False and", row("rejected", S.IDLE)),
    (
        DriverSupervisor,
        "_answer",
        "elsewhere is not None",
        "False",
        rig(test_activation.test_an_arm_that_is_elsewhere_is_not_activated),
    ),
    (DriverSupervisor, "_answer", "elif not reading.fault.calm:", "else:", row("waits", S.ACTIVATING)),
    (
        DriverSupervisor,
        "_read",
        "reading.fault or self._following",
        "self._following",
        rig(MIRRORED, FaultCode.EMERGENCY_STOP),
    ),
    (
        DriverSupervisor,
        "_read",
        " or self._following.judge(reading.q, now_ns)",
        "",
        row("astray", S.STOPPING),
    ),
    (
        DriverSupervisor,
        "step",
        "self._following.note(self._writer.written.q, now_ns)",
        "pass",
        lambda: AS_DECLARED(0.0, 45),
    ),
    (
        WatchedDriver,
        "read",
        "self._readings.judge(self._driver.read(), self._clock.now_ns())",
        "self._driver.read()",
        row("bad_reading", S.BRAKING),
    ),
    (
        DriverSupervisor,
        "_read",
        "if self.reading is not None or self.state not in INACTIVE or reading.code is not FaultCode.REFUSED:",
        "if True:",
        row("read_fails", S.IDLE),
    ),
    (
        DriverSupervisor,
        "_fail",
        "if self.fault is None or self.fault.calm:",
        "if True:",
        FIRST_FAULT,
    ),
    (DriverSupervisor, "_fail", "if self.state in INACTIVE:", "if False:", row("read_fails", S.HELD)),
    (
        DriverSupervisor,
        "step",
        "if stopped and self._writer.settled(now_ns):",
        "if stopped:",
        SLOW_STOP,
    ),
    (DriverSupervisor, "step", " and self.commanded.motion.resting", "", HARDLY_BEGUN),
    (PacedWriter, "hand_over", "self._scheduler.delay(2 * lead_ns)", "pass", rig(PAST, 0.9)),
    (PacedWriter, "step", "self._scheduler.repeat(now_ns)", "pass", rig(KEPT_AT_REST, 0.02)),
    (PacedWriter, "step", "if now_ns < self._due_ns:", "if False:", lambda: SLOW_PATH(15.0)),
    (WriteScheduler, "take", "self._waiting[0][0] <= furthest_ns", "True", lambda: LATE_DRIVER(7.9, "read", 60.0)),
    (WatchedDriver, "_call", "if took_ns > DEADLINE_NS", "if False", BY_DEADLINE),
    (WatchedDriver, "_call", "self._mark.set(begin_ns)", "pass", BY_DEADLINE),
    (
        WatchedDriver,
        "_call",
        "except BaseException as error:",
        "except DriverError as error:",
        rig(test_faults.test_a_driver_that_raises_is_stopped_and_named, KeyError("oops"), "write"),
    ),
]
MUTATIONS = [(Mutation(*check[:4]), check[4]) for check in CHECKS]
IDS = [f"{m.function}: {m.check.strip()}" for m, _ in MUTATIONS]


@pytest.mark.slow
@pytest.mark.parametrize(("mutation", "body"), MUTATIONS, ids=IDS)
def test_no_check_of_the_supervisor_can_be_taken_away(
    mutation: Mutation, body: Body, monkeypatch: pytest.MonkeyPatch
) -> None:
    body()
    mutation.apply(monkeypatch)
    with pytest.raises((AssertionError, KeyError, AttributeError)):
        body()
