"""A cycle comes back from its bytes bit for bit: what was recorded gives the same commands in another pipeline."""

import msgspec
import numpy as np
import pytest

from common.errors import MessageError
from common.messages.robot import SessionState
from lab.measure.soak.robot import kinematic
from lab.measure.soak.world import CONFIG, World
from remote_site.assist.sighting import MarkerSighting
from remote_site.reasons import Code, reason
from remote_site.recording.cycle_record import (
    CycleOutcome,
    decode_input,
    decode_outcome,
    encode_input,
    encode_outcome,
    outcome_of,
)
from remote_site.runtime.driven_pipeline import DrivenPipeline
from tests.present import present
from tests.remote_site.driven_loop import DrivenLoop
from tests.remote_site.teleop.cycle_log import Cycle, first_difference

SECONDS = 12.0


@pytest.fixture(scope="module")
def driven() -> list[tuple[Cycle, DrivenPipeline, CycleOutcome]]:
    """Some seconds of a troubled operator, link, driver and robot, each outcome as its bytes give it back."""
    seen: list[tuple[Cycle, DrivenPipeline, CycleOutcome]] = []
    true_cycle = DrivenPipeline.cycle

    def recording(self, *arguments, **named):
        snapshot = true_cycle(self, *arguments, **named)
        outcome = encode_outcome(outcome_of(len(seen) + 1, self.command, self.ordered, self.report))
        seen.append(((self.given, self.command), self, decode_outcome(outcome)))
        return snapshot

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(DrivenPipeline, "cycle", recording)
        World(kinematic, seed=21).run(SECONDS)
    return seen


@pytest.mark.slow
def test_inputs_from_their_bytes_give_the_same_commands_bit_for_bit(driven):
    states = {command.snapshot.state for (_, command), _, _ in driven}
    assert states >= {SessionState.ENGAGED, SessionState.DISENGAGED, SessionState.FAULT}
    again = [(decode_input(encode_input(given)), command) for (given, command), _, _ in driven]
    assert first_difference(CONFIG, again) == ""


def test_outcomes_from_their_bytes_are_what_was_decided(driven):
    for (_, command), _, kept in driven:
        snapshot = command.snapshot
        for name in ("q", "dq", "ddq"):
            assert getattr(kept.motion, name).tobytes() == getattr(command.motion, name).tobytes()
        assert (kept.gripper, kept.state, kept.reason) == (command.gripper, snapshot.state, snapshot.reason)
        assert (kept.readiness, kept.answers, kept.held) == (snapshot.readiness, snapshot.answers, snapshot.held)
        assert kept.target.tobytes() == snapshot.target.tobytes()
        assert kept.engagement == snapshot.engagement
        obeys = snapshot.obeys
        assert (kept.obeys is None) == (obeys is None)
        if obeys is not None:
            hand = obeys.sample
            assert kept.obeys == (hand.session, hand.seq, hand.capture_ns, obeys.born_ns)
    assert [kept.number for *_, kept in driven] == list(range(1, len(driven) + 1))


def test_what_the_robot_was_given_comes_from_an_order_before_it_and_says_when():
    loop = DrivenLoop()
    loop.start()
    orders = {}
    for _ in range(100):
        loop.tick(speed_m_s=0.1)
        driven = loop.driven
        kept = decode_outcome(encode_outcome(outcome_of(1, present(driven.command), driven.ordered, driven.report)))
        ordered, written = present(kept.ordered), present(kept.written)
        orders[ordered.seq] = ordered
        if written.seq in orders:
            order = orders[written.seq]
            assert written.q.tobytes() == order.q.tobytes()
            assert order.t_ns <= written.t_ns <= present(driven.given).now_ns
    assert len({order.q.tobytes() for order in orders.values()}) > 50
    assert written.seq >= ordered.seq - 1
    written = loop.robot.written[-1]
    assert written.q.tobytes() == loop.supervisor.written.q.tobytes()


def test_a_marker_and_its_refusal_come_back():
    loop = DrivenLoop()
    loop.tick()
    given = present(loop.driven.given)
    seen = MarkerSighting(3, 5, np.eye(4) * np.pi, None, ("a", "b"))
    unseen = MarkerSighting(4, 6, None, reason(Code.MARKER_UNSEEN, marker=4))
    markers = decode_input(encode_input(given._replace(markers=(seen, unseen)))).markers
    assert present(markers[0].base_T_marker).tobytes() == present(seen.base_T_marker).tobytes()
    assert markers[0]._replace(base_T_marker=None) == seen._replace(base_T_marker=None)
    assert markers[1] == unseen


@pytest.mark.parametrize("data", [b"", b"\x90", b"noise", msgspec.msgpack.encode((1, 2, 3))])
def test_other_bytes_are_refused(data):
    with pytest.raises(MessageError):
        decode_input(data)
    with pytest.raises(MessageError):
        decode_outcome(data)
