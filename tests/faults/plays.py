"""How faults are played: what is done to a pair of sites, and what is checked of it."""

import os
import signal
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from tests.faults.cell_pair import CellPair
from tests.faults.driver_log import ms
from tests.faults.forgery import ask_for_lease
from tests.faults.puppets import tell
from tests.faults.trial import FOLLOWING, Trial
from tests.integration.sites import child_of

Act = Callable[[CellPair], object]
Play = Callable[[Trial], None]

STILL_MM = 1.0
BACK_S = 2.0
WATCHDOG_MS = 200.0  # of the A465's controller
CALIBRATION_S = 22.0
SETTLES_WATCHED_S = 4.0
RETREAT_M = 0.1
OUTWARD = np.array([0.15, 0, 0, 0, 0, 0])


def hand(**words: Any) -> Act:
    """Something happens to the hand or its cameras."""
    return lambda pair: pair.hand(**words)


def robot(**words: Any) -> Act:
    """Something happens to the robot."""
    return lambda pair: pair.robot(**words)


def weather(**words: Any) -> Act:
    """Something happens to the link."""
    return lambda pair: pair.network.weather(**words)


def kill_local(pair: CellPair) -> None:
    """The local site is killed at once."""
    os.kill(pair.local.pid, signal.SIGKILL)


def latch(fault: Act, heal: Act, *, says: str = "", for_s: float = 0.0) -> Play:
    """A moving arm stops and latches, and stays where it is when the fault is over, however long it was."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        trial.latches()
        trial.rests()
        trial.check(says in trial.pair.state.reason, f"the reason does not say {says!r}: {trial.pair.state.reason}")
        time.sleep(max(for_s - trial.elapsed_s, 0.0))
        heal(trial.pair)
        trial.stays()

    return play


def partition(seconds: float) -> Play:
    """As above, and the command path is back soon after the partition heals."""
    play_latch = latch(weather(cut=True), lambda _: None, says="old", for_s=seconds)

    def play(trial: Trial) -> None:
        play_latch(trial)
        healed_ns = time.monotonic_ns()
        trial.pair.network.weather()
        trial.pair.wait("the command path", lambda: _hears(trial.pair), 20)
        took_ns = time.monotonic_ns() - healed_ns
        trial.note(f"a fresh sample {ms(took_ns):.0f} ms after it healed")
        trial.check(took_ns < BACK_S * NS_PER_S, f"the command path came back after {ms(took_ns):.0f} ms")
        trial.stays()

    return play


def hold(fault: Act, heal: Act, for_s: float) -> Play:
    """A moving arm stops for as long as the fault lasts."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        trial.rests()
        time.sleep(for_s)
        trial.check(not trial.log.moves_after(trial.rested_ns), "it moved during the fault")
        trial.note(f"{trial.pair.state.state.value}: {trial.pair.state.reason}")
        heal(trial.pair)

    return play


def blink(fault: Act, heal: Act, for_s: float) -> Play:
    """A fault too short to latch: the arm goes on, or stops and goes on, and never obeys what is too old."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        time.sleep(for_s)
        heal(trial.pair)
        time.sleep(1.5)
        trial.check(trial.pair.is_in(SessionState.ENGAGED), f"it does not follow: {trial.pair.state.reason}")
        trial.obeys_nothing_old()

    return play


def outlast(fault: Act, least_share: float) -> Play:
    """The arm follows while it lasts."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        trial.follows(least_share)
        trial.obeys_nothing_old()

    return play


def unmoved(fault: Act, *counted: str) -> Play:
    """An arm that follows a hand at rest does not move, and each of these refusals was counted."""

    def play(trial: Trial) -> None:
        time.sleep(0.7)
        before = dict(trial.pair.state.rejected)
        trial.begin(fault)
        time.sleep(0.3)
        state = trial.pair.state
        risen = {code: count - before.get(code, 0) for code, count in state.rejected.items()}
        trial.note(", ".join(f"{code} {count}" for code, count in risen.items() if count))
        for code in counted:
            trial.check(risen.get(code), f"{code} was not counted")
        places = trial.log.places
        way_mm = 1e3 * float(np.linalg.norm(places - places[0], axis=1).max(initial=0.0)) if len(places) else 0.0
        trial.note(f"commanded motion {way_mm:.2f} mm")
        trial.check(way_mm < STILL_MM, f"the tool was sent {way_mm:.1f} mm away")
        trial.ticks()

    return play


def jumps(count: int) -> Act:
    """The wrist is seen a metre off in so many frames."""
    return hand(jump_m=(0.0, 0.7, 0.7), jumps=count)


def jump_then_three(trial: Trial) -> None:
    """One jump is refused; three in a row latch; the arm is not moved by any."""
    unmoved(jumps(1), "jump")(trial)
    trial.check(trial.pair.state.state in FOLLOWING, "one jump ended the engagement")
    unmoved(jumps(3), "jumps")(trial)
    trial.latches()


def second_operator(act: Act) -> Play:
    """Another is refused with the holder's name, and what it sends is fenced."""

    def play(trial: Trial) -> None:
        answer = ask_for_lease(trial.pair, "ben")
        trial.note(f"{answer.code}: {answer.reason}")
        trial.check(not answer.done and "anna" in answer.reason, "the other was not refused with the holder's name")
        unmoved(act, "not_holder", "old_lease")(trial)
        trial.check(trial.pair.is_in(SessionState.ENGAGED), "the holder lost the arm")

    return play


def faulty(fault: Act, mend: Act, *, says: str, more_s: float = 0.0, silent: bool = False) -> Play:
    """The robot or its driver fails: the arm stops, the fault is told, and nothing but a request clears it."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.move()
        trial.begin(fault)
        trial.latches()
        trial.rests(more_s=more_s)
        trial.check(pair.is_in(SessionState.FAULT), f"no fault but {pair.state.state.value}")
        trial.check(says in pair.state.reason, f"the reason does not say {says!r}: {pair.state.reason}")
        if silent:
            trial.obeys_no_order()
            trial.check(not pair.ask(EngagementAction.ENGAGE).done, "it engaged with the fault still there")
        mend(pair)
        trial.stays()
        trial.check(pair.is_in(SessionState.FAULT) or silent, "the fault cleared itself")
        trial.ticks()

    return play


def reach_out(there: tuple[float, ...], seconds: float, *codes: str) -> Play:
    """The hand goes where the arm cannot: it says so, comes to rest without thrash, and comes back."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        trial.begin(hand(to=there, seconds=seconds))
        time.sleep(seconds + 1.5)
        seen = {state.code for state in pair.states if state.t_ns > trial.fault_ns}
        trial.note(f"said {', '.join(sorted(seen))}; {pair.state.reason}")
        trial.check(seen & set(codes), f"none of {codes} was said")
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
    pair.hand(to=pair.place_of(beyond), seconds=4.0)
    time.sleep(5.5)
    log = pair.log(trial.begun_ns)
    q5 = np.degrees(log.q[:, 4])
    codes = {state.code for state in pair.states if state.t_ns > trial.begun_ns}
    trial.note(f"joint 5 from {q5.min():.1f} to {q5.max():.1f} deg, said {', '.join(sorted(codes))}")
    trial.check(np.abs(q5).min() < 5.0, "joint 5 did not come near zero")
    pair.engage()


def kill_control(trial: Trial) -> None:
    """Control is killed: the driver's process stops the arm, and what starts again is not engaged."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.kill(child_of(pair.remote, "farhand-control"), signal.SIGKILL))
    trial.rests()
    pair.wait("the remote site to end", lambda: pair.remote.exit_code is not None, 10)
    trial.check("control" in "".join(pair.remote.lines), "the site does not name the dead process")
    _start_again(trial)


def kill_remote(trial: Trial) -> None:
    """All processes of the remote site are killed: the robot's own watchdog stops it."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.killpg(pair.remote.pid, signal.SIGKILL))
    trial.rests(told_within_s=WATCHDOG_MS / 1e3)
    _start_again(trial)


def _start_again(trial: Trial) -> None:
    trial.pair.start_remote()
    trial.pair.wait("a good hand", lambda: trial.pair.state.readiness.ready)
    trial.stays()


def close_page(trial: Trial) -> None:
    """The page whose key is held goes away: the arm stops, and one that comes back with the key down moves nothing."""
    pair, port = trial.pair, trial.pair.start_console()
    page = pair.start_page(port)
    pair.wait("readiness", lambda: pair.state.readiness.ready)
    pair.wait("the key to be seen let go", lambda: _presses(pair))
    pair.move()
    trial.begin(lambda _: os.kill(page.pid, signal.SIGKILL))
    trial.latches(0.5)
    trial.rests(told_within_s=0.5)
    pair.start_page(port)
    tell(pair.folder / "page", down=True)
    trial.stays(2.0)


def _presses(pair: CellPair) -> bool:
    """Let go of the page's key for a while, press it, and see whether the arm follows."""
    for down in (False, True):
        tell(pair.folder / "page", down=down)
        time.sleep(0.7)
    return pair.is_in(SessionState.ENGAGED)


def start_outside(trial: Trial) -> None:
    """An arm found beyond a joint's limit may only come back."""
    pair = trial.pair
    place = np.array(pair.take_up())
    pair.hand(to=(place + OUTWARD).tolist(), seconds=1.0)
    time.sleep(1.5)
    q1 = np.degrees(pair.log(trial.begun_ns).q[:, 0])
    trial.note(f"found at {q1[0]:.2f} deg, sent to at most {q1.max():.2f} deg by a hand that pushes on")
    trial.check(q1.max() <= q1[0] + 0.01, f"joint 1 was sent further out, to {q1.max():.2f} deg")
    pair.engage()
    trial.note(f"came back to {np.degrees(pair.state.q_commanded[0]):.2f} deg")


def bear(seconds: float, least_share: float, **words: Any) -> Play:
    """In such weather the arm follows, and obeys nothing that is too old."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(weather(**words))
        time.sleep(seconds)
        trial.follows(least_share)
        trial.obeys_nothing_old()

    return play


def lose(share: float, delay_ms: float, seconds: float) -> Play:
    """Lost packets never latch, and cost little of the tracking error at the same delay."""
    weather_play = bear(seconds, 0.9, loss=share, delay_ms=delay_ms)

    def play(trial: Trial) -> None:
        trial.pair.network.weather(delay_ms=delay_ms)
        trial.pair.move()
        time.sleep(CALIBRATION_S)
        since_ns = time.monotonic_ns() - round((CALIBRATION_S - 2) * NS_PER_S)
        errors = {lag_ms: trial.error_mm(since_ns, lag_ms * NS_PER_MS) for lag_ms in range(20, 400, 10)}
        lag_ms = min(errors, key=errors.__getitem__)
        weather_play(trial)
        error_mm = trial.error_mm(trial.fault_ns + 2 * NS_PER_S, lag_ms * NS_PER_MS)
        trial.note(f"error at {lag_ms} ms {errors[lag_ms]:.2f} mm, with loss {error_mm:.2f} mm")
        trial.check(error_mm <= 1.1 * errors[lag_ms], f"the error rose by {error_mm / errors[lag_ms] - 1:.0%}")

    return play


def crowd(mbit_s: float, delay_ms: float, seconds: float) -> Play:
    """Pictures fill the link that the hand samples share, once somebody watches; these come hardly later."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.network.weather(mbit_s=mbit_s, delay_ms=delay_ms)
        pair.move()
        trial.begin(lambda _: time.sleep(seconds))
        alone_ms = trial.late_ms(99)
        pair.start_page(pair.start_console())
        time.sleep(SETTLES_WATCHED_S)
        trial.begin(lambda _: time.sleep(seconds))
        watched_ms = trial.late_ms(99)
        trial.note(f"exposure to command p99 {alone_ms:.1f} ms alone, {watched_ms:.1f} ms beside the video")
        trial.check(watched_ms <= 1.3 * alone_ms, f"it rose by {watched_ms / alone_ms - 1:.0%}")
        trial.follows(0.95)

    return play


def wander(seconds: float) -> Play:
    """The hand goes to random places, far into everything that could be touched."""

    def play(trial: Trial) -> None:
        luck, pair = np.random.default_rng(6), trial.pair
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            place = (*luck.uniform(-0.5, 0.5, 2), luck.uniform(-0.6, 0.3), *luck.uniform(-0.8, 0.8, 3))
            takes = luck.uniform(0.6, 1.5)
            pair.hand(to=[float(x) for x in place], seconds=takes)
            time.sleep(takes)
        trial.keeps_distance()
        _retreat(trial)
        pair.start_remote()  # at its start: the wrist may be so wound up that no straight way leads back

    return play


def _retreat(trial: Trial) -> None:
    """Engaged where it stands, the arm follows a hand that leads it back to where it last was 10 cm away."""
    pair = trial.pair
    place = np.array(pair.take_up())
    log = pair.log(trial.begun_ns)
    ways = np.linalg.norm(log.places - log.places[-1], axis=1)
    before = log.q[np.flatnonzero(ways > RETREAT_M)[-1]]
    pair.hand(to=pair.place_of(before), seconds=1.0 + 3.0 * float(np.abs(place - pair.place_of(before)).max()))
    pair.wait(
        "its retreat",
        lambda: np.linalg.norm(pair.log(trial.begun_ns).places[-1] - log.places[-1]) > 0.8 * RETREAT_M,
        15,
    )


def _hears(pair: CellPair) -> bool:
    """Whether good samples come in: the newest state counts them, or has enough."""
    ready = pair.state.readiness
    return ready.ready or (ready.code == "collecting" and not ready.reason.startswith("0 "))
