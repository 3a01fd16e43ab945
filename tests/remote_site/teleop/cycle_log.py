"""Recorded control cycles: every input with what the pipeline made of it, written as they happen and replayed."""

import pickle
from collections.abc import Iterable, Iterator
from typing import IO

import numpy as np

from remote_site.kinematics.limits import load_arm
from remote_site.teleop.config import PipelineConfig
from remote_site.teleop.cycle import Command, CycleInput
from remote_site.teleop.pipeline import TeleopPipeline

Cycle = tuple[CycleInput, Command]


def write_cycle(stream: IO[bytes], given: CycleInput, command: Command) -> None:
    """Append one cycle."""
    pickle.dump((given, command), stream)
    stream.flush()


def read_cycles(stream: IO[bytes]) -> Iterator[Cycle]:
    """All whole cycles; the last may have been cut by the end of its process."""
    while True:
        try:
            yield pickle.load(stream)  # noqa: S301  # written by these tests
        except (EOFError, pickle.UnpicklingError):
            return


def first_difference(config: PipelineConfig, cycles: Iterable[Cycle]) -> str:
    """Feed the inputs through a new pipeline; names the first cycle that comes out otherwise, empty if none does."""
    pipeline = TeleopPipeline(config, *load_arm(config.robot))
    for k, (given, command) in enumerate(cycles):
        again = pipeline.cycle(given)
        if _bits(again) != _bits(command):
            return f"cycle {k}: {_bits(command)} before, {_bits(again)} again"
    return ""


def _bits(command: Command) -> tuple[object, ...]:
    """All of a command and its snapshot, joints by their bytes."""
    snapshot, motion = command.snapshot, command.motion
    activate_at = None if command.activate_at is None else command.activate_at.tobytes()
    obeys = None if snapshot.obeys is None else (snapshot.obeys.sample, snapshot.obeys.born_ns)
    joints = np.concatenate([motion.q, motion.dq, motion.ddq]).tobytes()
    answers, readiness = snapshot.answers, snapshot.readiness
    said = snapshot.state, snapshot.reason, readiness, answers, snapshot.held, dict(snapshot.rejected)
    tool = snapshot.target.tobytes(), snapshot.engagement, snapshot.assist
    return joints, command.gripper, activate_at, obeys, tool, said
