"""Every check of the driver's process is needed: with any one taken away, the test named beside it fails."""

import pytest

from remote_site.drivers.faults import FaultCode
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from tests.remote_site.drivers.supervisor import test_supervisor as of_keeper
from tests.remote_site.mutation import Mutation


def keeper(test, *arguments):
    return lambda: test(of_keeper.Bench(), *arguments)


IN_SILENCE = keeper(of_keeper.test_silence_begins_the_verified_stop_after_three_ticks_and_latches_at_the_time_out)
MIRRORED = of_keeper.test_a_fault_of_the_robot_is_mirrored_and_stays_when_the_robot_has_forgotten_it
MUTATIONS = [
    (
        Mutation(DriverSupervisor, "_obey", "if isinstance(verdict, Refused):", "if False:"),
        keeper(of_keeper.test_a_command_beyond_the_limits_never_reaches_the_robot_and_ends_in_the_stop, 0.5),
    ),
    (Mutation(DriverSupervisor, "_watch", "if silent_ns > limit_ns:", "if False:"), IN_SILENCE),
    (
        Mutation(DriverSupervisor, "_watch", "elif late_ns > self._grace_ns and self._onset is None:", "elif False:"),
        IN_SILENCE,
    ),
    (
        Mutation(DriverSupervisor, "take", "if order.diversions == self.diversions:", "if True:"),
        keeper(of_keeper.test_a_command_planned_before_the_stop_began_does_not_count),
    ),
    (
        Mutation(DriverSupervisor, "take", "elif self.phase is Phase.ACTIVE and not order.run:", "elif False:"),
        keeper(of_keeper.test_an_order_to_stop_stops_and_a_command_after_it_does_not_count),
    ),
    (
        Mutation(
            DriverSupervisor,
            "_activate",
            "if self.phase in (Phase.ACTIVE, Phase.STOPPING) or (self.reading and _moves(self.reading)):",
            "if False:",
        ),
        keeper(of_keeper.test_activation_waits_for_rest),
    ),
    (
        Mutation(DriverSupervisor, "_answer", "np.abs(reading.q - self.motion.q).max() > APART_RAD", "False"),
        keeper(of_keeper.test_an_arm_that_is_elsewhere_is_not_activated),
    ),
    (
        Mutation(
            DriverSupervisor, "_read", "elif reading.fault is not None and self.phase is not Phase.IDLE:", "elif False:"
        ),
        keeper(MIRRORED, FaultCode.EMERGENCY_STOP),
    ),
    (
        Mutation(DriverSupervisor, "_call", "if took_ns > DEADLINE_NS", "if False"),
        keeper(of_keeper.test_a_call_beyond_the_deadline_is_a_fault_and_visible_while_it_lasts),
    ),
    (
        Mutation(DriverSupervisor, "_call", "self._mark.set(begin_ns)", "pass"),
        keeper(of_keeper.test_a_call_beyond_the_deadline_is_a_fault_and_visible_while_it_lasts),
    ),
    (
        Mutation(DriverSupervisor, "_call", "except Exception as error:", "except DriverError as error:"),
        keeper(of_keeper.test_a_driver_that_raises_is_stopped_and_named, KeyError("oops")),
    ),
]
IDS = [f"{m.function}: {m.check}" for m, _ in MUTATIONS]


@pytest.mark.parametrize(("mutation", "body"), MUTATIONS, ids=IDS)
def test_no_check_of_the_keeper_can_be_taken_away(mutation, body, monkeypatch):
    body()
    mutation.apply(monkeypatch)
    with pytest.raises((AssertionError, KeyError, AttributeError)):
        body()
