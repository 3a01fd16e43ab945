"""Orders, silence and faults at random make no transition beside the supervisor's table."""

from itertools import pairwise
from random import Random

import pytest

from remote_site.drivers.faults import NOT_ACTIVATED
from remote_site.drivers.supervisor.state import INACTIVE, SupervisorState
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from tests.remote_site.drivers.supervisor.supervised import START, Supervised
from tests.remote_site.drivers.supervisor.transition_table import CASES, PRESSED


@pytest.mark.slow
def test_chance_finds_no_transition_beside_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[SupervisorState] = []

    def note(supervisor: DriverSupervisor, name: str, value: object) -> None:
        if name == "state":
            assert isinstance(value, SupervisorState)
            seen.append(value)
        object.__setattr__(supervisor, name, value)

    monkeypatch.setattr(DriverSupervisor, "__setattr__", note)
    listed = {(state, row.next or state) for row, state in CASES}
    found = set()
    for seed in range(40):
        seen.clear()
        wander(Supervised(), Random(seed))  # noqa: S311
        found |= set(pairwise(seen))
    changes = {(one, other) for one, other in found if one is not other}
    assert changes <= listed
    assert len(changes) > 10


def wander(rig: Supervised, rng: Random) -> None:
    """Ninety turns of commands, silence, faults and activations at random."""
    for _ in range(90):
        event = rng.random()
        rig.robot.trouble = PRESSED if event < 0.01 else None
        call = rng.choice(["activate", "read", "write", "stop"])
        rig.robot.raises = {call: KeyError("oops")} if event > 0.98 else {}
        if rig.supervisor.state in INACTIVE or event < 0.03:
            rig.robot.trouble = rng.choice([None, None, NOT_ACTIVATED])
            rig.activate(START if rig.supervisor.reading is None else rig.supervisor.reading.q)
        elif event < 0.2:
            rig.stumble(rng.uniform(2, 60))
        elif event < 0.25:
            rig.turn(rig.order(rig.sent, run=event > 0.22))
        elif rig.supervisor.commanded.stop is not None:
            rig.sent = rig.stop_at()
            rig.turn(rig.order(rig.sent), ms=0)
        else:
            rig.command()
