"""Judgement of a live trial: watched in the simulated cell's process, written when that ends."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from common.atomic_file import write_atomically
from common.clock import NS_PER_S
from lab.experiments.placing.judge import Judge, Placed
from remote_site.config import RemoteConfig
from remote_site.simulation.process import SimulatedCell


class TrialJudgement(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The end of a trial: where the block was left, and what was counted on the way."""

    end: Placed
    drops: int
    collisions: int
    grip_force_n: float


@contextmanager
def judged(config: RemoteConfig, out: Path, cell: SimulatedCell) -> Iterator[Callable[[], None]]:
    """Watch the cell once in each control period; nothing leaves this process before the cell ends."""
    judge, steps = Judge(config, cell), 0
    steps_per_look = max(1, round(NS_PER_S / config.control.rate_hz / (cell.dt * NS_PER_S)))

    def stepped() -> None:
        nonlocal steps
        steps += 1
        if steps % steps_per_look == 0:
            judge.watch()

    yield stepped
    ended = TrialJudgement(
        end=judge.placed(), drops=judge.drops, collisions=judge.collisions, grip_force_n=judge.grip_force_n
    )
    write_atomically(out, msgspec.json.encode(ended))
