"""One fault on a pair of sites: what happened, what was measured, and which promises were broken."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import FOLLOWING, Obeyed, SessionState
from remote_site.safety.collision import CollisionModel
from tests.faults.cell_pair import SETTLES_S, CellPair
from tests.faults.driver_log import DriverLog, Worst, ms
from tests.late_machine import was_late

QUIET_S = 0.4
SETTLED_M = 1e-4
SEEN_S = 0.3  # until what the remote site refused is in its state
TURN_NS = 2 * NS_PER_MS  # period of the driver's process
LEAST_STATES_HZ = 40.0  # of 50
LEAST_COUNTED_S = 1.0  # in less, one that is a little late counts too much
MORE_STATES = 20  # that have to come on a machine whose pace is not judged
PATIENCE_S = 20.0  # of a shared machine, for what comes at once on a quiet one
EVERY = 5  # of the commands: 20 ms


@dataclass
class Outcome:
    """What the report shows of a row; None where nothing had to stop. `was_late` is of the machine, not of a row."""

    stop_ms: float | None = None
    bound_ms: float | None = None
    travel_mm: float | None = None
    deceleration: float | None = None
    worst: Worst | None = None
    notes: list[str] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    was_late: bool = False


class Trial:
    """The pair with the clock of one row; checks are collected, so that the report shows all of them."""

    def __init__(self, pair: CellPair, outcome: Outcome, pause_ns: int = 0) -> None:
        """`pause_ns` is how late a machine that is shared may make a stop; where it is 0, every time is judged."""
        self.pair, self.outcome, self._pause_ns = pair, outcome, pause_ns
        self._patience_s = PATIENCE_S if pause_ns else 0.0
        self.begun_ns = self.fault_ns = self.rested_ns = time.monotonic_ns()

    def check(self, so: object, what: str) -> None:
        """Note a failure unless something is so."""
        if not so:
            self.outcome.failures.append(what)

    def note(self, what: str) -> None:
        """Add a measured result to the report."""
        self.outcome.notes.append(what)

    def begin(self, fault: Callable[[CellPair], object]) -> None:
        """Let the fault happen."""
        self.fault_ns = time.monotonic_ns()
        fault(self.pair)

    def settle(self) -> None:
        """Wait until an arm that follows a hand at rest has arrived."""
        time.sleep(SETTLES_S)
        if self._patience_s:
            self.pair.wait("the arm to settle", self._has_settled, self._patience_s)

    def _has_settled(self) -> bool:
        positions = self.pair.log(time.monotonic_ns() - round(QUIET_S * NS_PER_S)).positions
        return bool(len(positions)) and float(np.ptp(positions, axis=0).max()) < SETTLED_M

    def provoke(self, fault: Callable[[CellPair], object], counted: tuple[str, ...]) -> dict[str, int]:
        """Let the fault happen; how often each code has been counted since.

        A shared machine may be late to count, or so late with a sample that it is refused as old: then it comes again.
        """
        before = dict(self.pair.state.rejected)
        self.begin(fault)
        time.sleep(SEEN_S)
        while not (risen := self._risen(before)).keys() >= set(counted) and self.elapsed_s < self._patience_s:
            fault(self.pair)
            time.sleep(SEEN_S)
        return risen

    def _risen(self, before: dict[str, int]) -> dict[str, int]:
        now = self.pair.state.rejected
        return {code: n - before.get(code, 0) for code, n in now.items() if n > before.get(code, 0)}

    @property
    def elapsed_s(self) -> float:
        """Since the fault."""
        return (time.monotonic_ns() - self.fault_ns) / NS_PER_S

    @property
    def log(self) -> DriverLog:
        """What the driver has recorded since the fault."""
        return self.pair.log(self.fault_ns)

    def latches(self, within_s: float = 1.0) -> None:
        """The engagement ends."""
        pair = self.pair
        pair.wait("the latch", lambda: pair.state.state not in FOLLOWING, within_s + self._patience_s)
        self.note(f"latched after {ms(pair.state.t_ns - self.fault_ns):.0f} ms: {pair.state.reason}")

    def rests(self, *, more_s: float = 0.0, stop_within_s: float | None = None) -> None:
        """The arm rests by T_soft, two ticks and the stop's time after the last good sample.

        Where good samples keep coming, the stop begins within `stop_within_s` of the fault. `more_s` is how long a
        driver blocks.
        """
        time.sleep(QUIET_S)
        if self._patience_s:
            self.pair.wait("rest", self._is_quiet, self._patience_s)
        pair, log = self.pair, self.pair.log(self.begun_ns)
        if stop_within_s is None:
            assert pair.state.obeyed is not None, "no sample was obeyed"
            onset_ns = pair.state.obeyed.capture_ns + round(pair.state.age_limit_ms * NS_PER_MS)
        else:
            onset_ns = self.fault_ns + round(stop_within_s * NS_PER_S)
        grace_ns = round(2 * NS_PER_S / pair.config.control.rate_hz)
        self._rested(log, log.rest_ns(onset_ns, grace_ns) + round(more_s * NS_PER_S) + TURN_NS)

    def _is_quiet(self) -> bool:
        """Whether the driver has recorded rest, and nothing else, for a while."""
        log = self.pair.log(time.monotonic_ns() - round(QUIET_S * NS_PER_S))
        return bool(len(log.reads)) and not log.moves_after(0)

    def _rested(self, log: DriverLog, bound_ns: int) -> None:
        moved = (log.last_moving_ns(log.writes), log.last_moving_ns(log.reads), self.fault_ns)
        self.rested_ns = max(t_ns for t_ns in moved if t_ns is not None)
        self.outcome.stop_ms, self.outcome.bound_ms = (ms(t_ns - self.fault_ns) for t_ns in (self.rested_ns, bound_ns))
        self.outcome.travel_mm = log.travel_mm(self.fault_ns, self.rested_ns)
        self.outcome.deceleration = log.deceleration(self.fault_ns, self.rested_ns)
        late_ns = self.rested_ns - bound_ns
        self.check(late_ns <= self._pause_ns, f"rest {ms(late_ns):.1f} ms after the bound")

    def stays(self, seconds: float = 1.0) -> None:
        """Nothing moves, and nothing engages by itself, although the fault is over."""
        time.sleep(seconds)
        self.check(not self.log.moves_after(self.rested_ns), "it moved without a new engagement")
        self.check(self.pair.state.state not in FOLLOWING, "it engaged by itself")

    def late_ms(self, percentile: float) -> float:
        """From a sample's exposure to its first command, of those obeyed since the fault."""
        ages = {
            s.obeyed.seq: s.obeyed.command_ns - s.obeyed.capture_ns
            for s in self.pair.states
            if s.obeyed and s.obeyed.capture_ns > self.fault_ns
        }
        self.check(ages, "no sample was obeyed")
        return ms(float(np.percentile(list(ages.values()) or [0], percentile)))

    def obeys_nothing_old(self) -> None:
        """No sample was older than the limit in force when its first command was written."""
        limits: dict[Obeyed, float] = {}
        for state in self.pair.states:
            if state.obeyed is not None and state.obeyed.command_ns > self.fault_ns:
                limits.setdefault(state.obeyed, state.age_limit_ms)
        ages = {obeyed: ms(obeyed.command_ns - obeyed.capture_ns) for obeyed in limits}
        self.note(f"{len(ages)} samples obeyed, the oldest {max(ages.values(), default=0):.0f} ms old")
        self.check(ages, "no sample was obeyed")
        too_old = [f"{age:.0f} ms of {limits[obeyed]:.0f}" for obeyed, age in ages.items() if age > limits[obeyed]]
        self.check(not too_old, f"samples were too old: {', '.join(too_old)}")

    def obeys_no_command(self) -> None:
        """No command has reached the robot since it rested."""
        writes = self.log.writes
        self.check(not (writes["t_ns"] > self.rested_ns).any(), "commands came in spite of the fault")

    def follows(self, least_fraction: float) -> None:
        """The arm never latches and follows for at least this fraction of the time; where that is 0, it may latch."""
        states = [state.state for state in self.pair.states if state.t_ns > self.fault_ns]
        fraction = states.count(SessionState.ENGAGED) / len(states)
        self.note(f"followed {fraction:.1%} of {self.elapsed_s:.0f} s")
        latched = not all(state in FOLLOWING for state in states)
        self.note(f"latched: {self.pair.state.reason}" if latched else "never latched")
        self.check(not (latched and least_fraction), f"it latched: {self.pair.state.reason}")
        self.check(fraction >= least_fraction, f"it followed only {fraction:.0%} of the time")

    def error_mm(self, between_ns: tuple[int, int], lag_ms: float) -> float:
        """The distance of the tool from where the hand asked for it `lag_ms` before, rms in mm."""
        pair, (since_ns, until_ns), delay_ns = self.pair, between_ns, round(lag_ms * NS_PER_MS)
        writes = pair.log(since_ns).writes[::EVERY]
        writes = writes[writes["t_ns"] < until_ns]
        start, scale = pair.model.forward(pair.config.robot.start)[:3, 3], pair.config.mapping.scale
        hand = np.array([pair.scripted.path.at(int(t_ns) - delay_ns)[:3] for t_ns in writes["t_ns"]])
        wanted = start + scale * hand @ np.array(pair.config.mapping.base_R_operator).T
        tool = np.array([pair.model.forward(q)[:3, 3] for q in writes["motion"][:, 0]])
        return 1e3 * float(np.sqrt(np.mean(np.sum((tool - wanted) ** 2, axis=1))))

    def keeps_distance(self) -> None:
        """No command since the row began brings the arm nearer to anything than the margin."""
        config, q = self.pair.config, self.pair.log(self.begun_ns).q[::EVERY]
        collision = CollisionModel.from_urdf(
            config.robot.urdf, self.pair.model, config.robot.capsules, config.safety.collision
        )
        least = min(collision.distance(posture) for posture in q)
        self.note(f"least distance {1e3 * least:.2f} mm of {1e3 * collision.margin:.0f} mm in {len(q)} postures")
        self.check(least >= collision.margin - 1e-6, f"only {1e3 * least:.2f} mm of distance")

    def ticks(self) -> None:
        """The control loop keeps ticking after the fault: its states keep coming, at their rate where times count."""
        pair = self.pair
        if self._patience_s:
            seq = pair.state.seq
            pair.wait("more states", lambda: pair.state.seq >= seq + MORE_STATES, self._patience_s)
            return
        first = next(state for state in pair.states if state.t_ns > self.fault_ns)
        time.sleep(max(LEAST_COUNTED_S - (time.monotonic_ns() - first.t_ns) / NS_PER_S, 0.0))
        count, took_s = pair.state.seq - first.seq, (time.monotonic_ns() - first.t_ns) / NS_PER_S
        self.check(count > LEAST_STATES_HZ * took_s - 1, f"only {count} states in {took_s:.2f} s")

    def was_late(self) -> bool:
        """Whether the machine has ended an engagement since the row began, by standing still."""
        return any(was_late(state.reason) for state in self.pair.states if state.t_ns >= self.begun_ns)

    def end(self) -> None:
        """The invariant on every command of the row."""
        self.outcome.worst = worst = self.pair.log(self.begun_ns).worst()
        self.check(worst.within, f"beyond the limits: {worst}")
