"""A cycle depends on its inputs alone: what was recorded gives the same commands when it is fed through again."""

from dataclasses import replace

import numpy as np
import pytest

from common.messages.robot import SessionState
from lab.measure.soak.robot import c500c, kinematic
from lab.measure.soak.world import CONFIG, World
from remote_site.teleop.cycle import CycleInput
from remote_site.teleop.pipeline import TeleopPipeline
from tests.remote_site.teleop.cycle_log import Cycle, first_difference

SECONDS = 20.0


@pytest.fixture(scope="module", params=[kinematic, c500c], ids=["kinematic", "c500c"])
def recorded(request: pytest.FixtureRequest) -> list[Cycle]:
    """Twenty stepped seconds of a troubled operator, link, driver and robot."""
    cycles: list[Cycle] = []
    true_cycle = TeleopPipeline.cycle

    def recording(self, given):
        command = true_cycle(self, given)
        cycles.append((given, command))
        return command

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(TeleopPipeline, "cycle", recording)
        World(request.param, seed=21).run(SECONDS)
    return cycles


def test_every_command_comes_again_bit_for_bit(recorded):
    states = {command.snapshot.state for _, command in recorded}
    assert states >= {SessionState.ENGAGED, SessionState.HOLDING, SessionState.DISENGAGED, SessionState.FAULT}
    assert any(given.requests for given, _ in recorded)
    assert any(not given.robot.ready for given, _ in recorded)
    assert any(command.activate_at is not None for _, command in recorded)
    assert first_difference(CONFIG, recorded) == ""


def changed(given: CycleInput) -> CycleInput:
    """The same cycle, a nanosecond later or with what was really sent a little elsewhere."""
    sent = given.robot.sent
    return given._replace(robot=given.robot._replace(sent=replace(sent, q=sent.q + 1e-12)))


def test_a_cycle_that_began_otherwise_is_noticed(recorded):
    k = next(k for k, (_, command) in enumerate(recorded) if command.snapshot.state is SessionState.ENGAGED)
    given, command = recorded[k]
    assert np.abs(given.robot.sent.q).max() > 0
    other = [*recorded[:k], (changed(given), command)]
    assert first_difference(CONFIG, other).startswith(f"cycle {k}:")
