"""Hands that lead the arm where it cannot go: out of reach, past a singularity, beyond a limit, into obstacles."""

import time

import numpy as np

from common.clock import NS_PER_S
from tests.faults.acts import hand
from tests.faults.plays import Play
from tests.faults.trial import Trial

RETREAT_M = 0.1
OUTWARD = np.array([0.15, 0, 0, 0, 0, 0])


def reach_out(there: tuple[float, ...], seconds: float, *codes: str) -> Play:
    """The hand goes where the arm cannot: the site reports it, and the arm rests and returns."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        trial.begin(hand(to=there, seconds=seconds))
        time.sleep(seconds + 1.5)
        seen = {state.code for state in pair.states if state.t_ns > trial.fault_ns}
        trial.note(f"reported {', '.join(sorted(seen))}; {pair.state.reason}")
        trial.check(seen & set(codes), f"none of {codes} was reported")
        calm = pair.log(time.monotonic_ns() - NS_PER_S)
        trial.note(f"fastest joint in the last second {calm.fastest:.3f} rad/s")
        trial.check(calm.fastest < 0.05, f"it thrashes: {calm.fastest:.2f} rad/s")
        pair.engage()

    return play


def sweep_wrist(trial: Trial) -> None:
    """Joint 5 is led from -45 deg through zero, and back."""
    pair = trial.pair
    pair.start_remote()  # at its very start: a wrist that is a little turned passes beside the singularity
    pair.engage()
    beyond = np.array(pair.config.robot.start) + np.radians([0, 0, 0, 0, 75, 0])
    pair.hand(to=pair.scripted.pose_of(beyond), seconds=4.0)
    time.sleep(5.5)
    log = pair.log(trial.begun_ns)
    q5 = np.degrees(log.q[:, 4])
    codes = {state.code for state in pair.states if state.t_ns > trial.begun_ns}
    trial.note(f"joint 5 from {q5.min():.1f} to {q5.max():.1f} deg, reported {', '.join(sorted(codes))}")
    trial.check(np.abs(q5).min() < 5.0, "joint 5 did not come near zero")
    pair.engage()


def start_outside(trial: Trial) -> None:
    """An arm found beyond a joint's limit may only return."""
    pair = trial.pair
    pose = np.array(pair.follow_from_here())
    pair.hand(to=(pose + OUTWARD).tolist(), seconds=1.0)
    time.sleep(1.5)
    q1 = np.degrees(pair.log(trial.begun_ns).q[:, 0])
    trial.note(f"found at {q1[0]:.2f} deg, sent to at most {q1.max():.2f} deg by a hand that keeps pushing")
    trial.check(q1.max() <= q1[0] + 0.01, f"joint 1 was sent further out, to {q1.max():.2f} deg")
    pair.engage()
    trial.note(f"came back to {np.degrees(pair.state.q_commanded[0]):.2f} deg")


def wander(seconds: float) -> Play:
    """The hand goes to random poses, far into everything that the arm could touch."""

    def play(trial: Trial) -> None:
        rng, pair = np.random.default_rng(6), trial.pair
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            pose = (*rng.uniform(-0.5, 0.5, 2), rng.uniform(-0.6, 0.3), *rng.uniform(-0.8, 0.8, 3))
            takes = rng.uniform(0.6, 1.5)
            pair.hand(to=[float(x) for x in pose], seconds=takes)
            time.sleep(takes)
        trial.keeps_distance()
        _retreat(trial)
        pair.start_remote()  # at its start: the wrist may be so wound up that no straight path leads back

    return play


def _retreat(trial: Trial) -> None:
    """Engaged where it is, the arm follows a hand that leads it back to where it last was 10 cm away."""
    pair = trial.pair
    pose = np.array(pair.follow_from_here())
    log = pair.log(trial.begun_ns)
    distances = np.linalg.norm(log.positions - log.positions[-1], axis=1)
    before = log.q[np.flatnonzero(distances > RETREAT_M)[-1]]
    back = pair.scripted.pose_of(before)
    pair.hand(to=back, seconds=1.0 + 3.0 * float(np.abs(pose - back).max()))
    pair.wait(
        "its retreat",
        lambda: np.linalg.norm(pair.log(trial.begun_ns).positions[-1] - log.positions[-1]) > 0.8 * RETREAT_M,
        15,
    )
