"""The recorded inputs through today's pipeline: whether every command comes again, and where it first does not."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_S
from farhand.replay.recorded_cycles import RecordedCycle
from remote_site.kinematics.joints import JointMotion
from remote_site.recording.cycle_record import CycleOutcome
from remote_site.teleop.cycle import Command
from remote_site.teleop.pipeline import TeleopPipeline

SAME_RAD = 1e-9  # of positions (also rad/s, rad/s²): another processor rounds otherwise
DECIDED = (
    "state",
    "reason",
    "engagement",
    "engagements",
    "gripper_toggles",
    "readiness",
    "held",
    "answers",
    "rejected",
    "assist",
)


@dataclass(frozen=True, slots=True)
class Difference:
    """The first cycle whose command is another one: its number, its time since the first cycle (s), and in what."""

    cycle: int
    at_s: float
    what: str


@dataclass(frozen=True, slots=True)
class ReplayVerdict:
    """The verdict of a replay: cycles compared, largest joint difference (rad), and the first difference, if any."""

    cycles: int
    worst_rad: float
    difference: Difference | None

    def in_words(self, other_release: str = "") -> str:
        """One sentence for a person; `other_release` says which recorded it, empty where it was this one."""
        found = self.difference
        if found is not None:
            said = f"cycle {found.cycle}, {found.at_s:.3f} s after the first, comes out otherwise: {found.what}"
            cure = "its rules may be others: verify it with the release that recorded it"
            return f"{other_release}: {said}; {cure}" if other_release else said
        how = "bit for bit" if self.worst_rad == 0.0 else f"to {self.worst_rad:.1e} rad"
        return f"all {self.cycles} control cycles give the same commands, {how}"


def verify(
    cycles: Iterable[RecordedCycle], pipeline: TeleopPipeline, progress: Callable[[], None] = lambda: None
) -> ReplayVerdict:
    """Feed recorded inputs through a new pipeline, up to the first command that differs by more than rounding."""
    count, worst_rad, first_ns = 0, 0.0, 0
    for given, recorded in cycles:
        first_ns = first_ns or given.now_ns
        again = pipeline.cycle(given)
        count, apart_rad = count + 1, _apart(again.motion, recorded.motion)
        worst_rad = max(worst_rad, apart_rad)
        what = _what_differs(again, recorded, apart_rad)
        if what:
            at_s = (given.now_ns - first_ns) / NS_PER_S
            return ReplayVerdict(count, worst_rad, Difference(recorded.number, at_s, what))
        progress()
    return ReplayVerdict(count, worst_rad, None)


def _what_differs(again: Command, recorded: CycleOutcome, apart_rad: float) -> str:
    """In which part a command differs from the recorded one, empty if in none."""
    if not apart_rad <= SAME_RAD:
        return f"the joints' motion differs by {apart_rad:.1e} rad (or rad/s, rad/s²)"
    snapshot = again.snapshot
    obeys = snapshot.obeys.sample.seq if snapshot.obeys is not None else None
    pairs = {name: (getattr(snapshot, name), getattr(recorded, name)) for name in DECIDED}
    pairs["gripper"] = again.gripper, recorded.gripper
    pairs["sample that is obeyed"] = obeys, recorded.obeys.seq if recorded.obeys is not None else None
    pairs["activation"] = again.activate_at is not None, recorded.activate_at is not None
    for name, (now, before) in pairs.items():
        if now != before:
            return f"{name} was {before}, is {now}"
    if not np.allclose(snapshot.target, recorded.target, rtol=0.0, atol=SAME_RAD, equal_nan=True):
        return "the tool's target differs"
    return ""


def _apart(one: JointMotion, other: JointMotion) -> float:
    """The largest difference of positions, velocities and accelerations; NaN where one is not a number."""
    both = zip((one.q, one.dq, one.ddq), (other.q, other.dq, other.ddq), strict=True)
    return float(max(np.max(np.abs(a - b)) for a, b in both))
