"""Samples of the lease's holder with numbers that no hand makes: control goes on, and can send and keep every cycle."""

from pathlib import Path

import numpy as np
import pytest

from common.messages.codec import decode, encode
from common.messages.robot import LoopTiming, RobotState, SessionState
from remote_site.recording.cycle_record import decode_input, encode_input
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.taps import ControlTap
from remote_site.runtime.reporting import Reporter
from remote_site.runtime.site_memory import SiteMemory
from remote_site.session.samples import NamedSample, as_of_now
from tests.present import present
from tests.remote_site.driven_loop import CONFIG, DrivenLoop
from tests.remote_site.hostile_hand import HostileHand
from tests.remote_site.remote_loop import TICK_NS, arm, collision_model

TIMING = LoopTiming(250.0, 100.0, 0, 0, False)


class EncodedStates:
    """Where states go: as bytes, and back."""

    def __init__(self) -> None:
        self.payload_bytes = 0
        self.newest: RobotState | None = None

    def put(self, state: RobotState) -> None:
        self.newest = decode(encode(state), RobotState, 100_000)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_any_samples_that_the_wire_accepts_leave_control_cycles_that_can_be_sent_and_kept(
    tmp_path: Path, seed: int
) -> None:
    loop, hostile, states = DrivenLoop(), HostileHand(seed), EncodedStates()
    loop.start()
    memory = RecordingMemory.create(tmp_path / "memory", loop.clock.now_ns())
    tap = ControlTap(memory, loop.clock)
    reporter = Reporter(states, SiteMemory(), arm()[0], collision_model(CONFIG), lambda: TIMING, one_host=True, tap=tap)  # type: ignore[arg-type]  # it encodes, and sends nothing
    for seq in range(300):
        loop.clock.advance_ms(TICK_NS / 2e6)
        loop.process.turn()
        now_ns = loop.clock.now_ns()
        memory.beat(now_ns)
        samples = [
            NamedSample("operator-7", as_of_now(hostile.sample(seq + k, now_ns), -271_000_000)) for k in range(3)
        ]
        loop.snapshot = loop.driven.cycle(now_ns, loop.leases.status(now_ns), samples, [])
        tap.note_cycle(
            present(loop.driven.given), present(loop.driven.command), loop.driven.ordered, loop.driven.report
        )
        reporter.note(loop.snapshot, loop.driven)
        reporter.publish(loop.snapshot, loop.driven, {})
        assert decode_input(encode_input(present(loop.driven.given))).now_ns == now_ns
    assert states.newest is not None
    assert states.newest.state is not SessionState.ENGAGED or np.isfinite(states.newest.q).all()
    assert loop.robot.finite
    assert sum(loop.snapshot.rejected.values()) > 500
    memory.remove()
    memory.close()
