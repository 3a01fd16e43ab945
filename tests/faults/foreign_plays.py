"""What other programs and other hosts' clocks do beside an arm that follows: a strange recorder, a slewed clock."""

import threading
import time
from bisect import bisect_right
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from statistics import median

import msgspec

from common.clock import NS_PER_MS, NS_PER_S
from common.link.channels import CAMERA, SHOWN, ChannelSession
from common.link.transport import open_link
from common.messages.recording import RecordingState
from common.messages.video import VideoFrame, ViewCame, ViewShown, ViewsShown
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.memory_files import memory_place
from remote_site.recording.taps import UNREADABLE
from tests.common.recording.recorder_states import recorder
from tests.faults.cell_pair import CellPair
from tests.faults.pair_setup import CELL, OPERATOR
from tests.faults.trial import Trial

SLEW = 0.08
SLEWED_S = 8.0  # each way
REPORT_S = 0.1
WARM_NS = NS_PER_S  # until what is stated of the last samples tells of the slewed clock alone
LEAST_AGES, UNSURE_MS = 100, 8.0  # a command takes up to 33 ms to the operator's host: 16 % of that at the turn
BEATS, BEAT_S = 10, 0.1
CAMERA_NAME = "side"
STATE = recorder(writing=True, on_request=False)


def record_strangely(trial: Trial) -> None:
    """A recorder writes what this release does not know, and what nobody can read: the arm follows on."""
    pair = trial.pair
    pair.move()
    memory = RecordingMemory.attach(memory_place(CELL, pair.config.links))
    assert memory is not None, "the site has made no memory for a recorder"
    try:
        trial.begin(lambda _: None)
        of_tomorrow = msgspec.to_builtins(STATE) | {"cameras": ["side"], "alarm": "disk " * 200}
        told = _write(pair, memory, msgspec.msgpack.encode(of_tomorrow))
        trial.check(told is not None and told.alarm.startswith("disk disk"), f"its alarm is not told: {told}")
        for data in (b"", b"\x91" * 1000, msgspec.msgpack.encode({"writing": float("nan")})):
            told = _write(pair, memory, data)
            trial.check(told == UNREADABLE, f"it is not told that a recorder is there: {told}")
    finally:
        memory.close()
    trial.follows(0.95)
    trial.obeys_nothing_old()
    trial.check(pair.remote.exit_code is None, "the site has ended")


def _write(pair: CellPair, memory: RecordingMemory, data: bytes) -> RecordingState | None:
    """Write a recorder's state for a second; what the site tells of it then."""
    for _ in range(BEATS):
        memory.beat(time.monotonic_ns())
        memory.status.write(data)
        time.sleep(BEAT_S)
    return pair.state.recording


def slew_the_operator(trial: Trial) -> None:
    """The clock of the operator's host gains 8 %, then loses them: it follows, ages are true, video and site live."""
    pair = trial.pair
    pair.move()
    with _console(pair) as console:
        pair.wait("pictures", lambda: console.came, 10)
        trial.begin(lambda _: None)
        clock = _SlewedTimes()
        for rate in (SLEW, -SLEW):
            pair.hand(slew=rate)
            clock.slew(rate)
            console.rate = rate
            time.sleep(SLEWED_S)
        trial.follows(0.95)
        _check_ages(trial, clock)
        came = console.came
        pair.wait("more pictures", lambda: console.came > came + 10, 5)
        trial.note(f"{console.came} pictures came")
    trial.check(pair.remote.exit_code is None, "the site has ended")
    pair.start_local()  # its clock is the machine's again


class _SlewedTimes:
    """Tells the machine's time of stamps of a clock that was slewed, as exactly as is known since when it was."""

    def __init__(self) -> None:
        self._machine_ns, self._clock_ns, self._rates = [0.0], [0.0], [0.0]

    def slew(self, rate: float) -> None:
        """The clock gains at this rate from now on."""
        now_ns = float(time.monotonic_ns())
        self._clock_ns.append(self._clock_ns[-1] + (now_ns - self._machine_ns[-1]) * (1.0 + self._rates[-1]))
        self._machine_ns.append(now_ns)
        self._rates.append(rate)

    def machine_ns(self, stamp_ns: int) -> float:
        """The machine's time when the clock read `stamp_ns`."""
        k = bisect_right(self._clock_ns, stamp_ns) - 1
        return self._machine_ns[k] + (stamp_ns - self._clock_ns[k]) / (1.0 + self._rates[k])


def _check_ages(trial: Trial, clock: _SlewedTimes) -> None:
    """No sample was obeyed beyond the limit, and none stated to be younger than samples were, by the machine's time."""
    states = [state for state in trial.pair.states if state.t_ns > trial.fault_ns + WARM_NS]
    limits = {state.obeyed: state.age_limit_ms for state in reversed(states) if state.obeyed is not None}
    ages = {one: (one.command_ns - clock.machine_ns(one.capture_ns)) / NS_PER_MS for one in limits}
    trial.check(len(ages) > LEAST_AGES, f"{len(ages)} samples alone were obeyed")
    too_old = [f"{age:.0f} ms" for one, age in ages.items() if age > limits[one] + UNSURE_MS]
    trial.check(not too_old, f"samples were too old: {', '.join(too_old)}")
    stated = [link.age_ms for state in states if (link := state.hand_link) is not None and link.age_ms is not None]
    usual = median(ages.values())
    trial.note(f"samples {usual:.0f} ms old were stated to be {min(stated):.0f} to {max(stated):.0f} ms old at most")
    trial.check(min(stated) > usual - UNSURE_MS, "samples were stated to be younger than they are")


class _Console:
    """Takes pictures, and reports them by a clock that is slewed; the lease is the operator's."""

    def __init__(self) -> None:
        self.rate, self.came = 0.0, 0
        self.own_ns = float(time.monotonic_ns())
        self._newest: VideoFrame | None = None
        self._ended = threading.Event()

    def take(self, frame: VideoFrame, _now_ns: int) -> None:
        """A picture has come."""
        self._newest, self.came = frame, self.came + 1

    def end(self) -> None:
        """Report no more."""
        self._ended.set()

    def report(self, pair: CellPair, put: Callable[[ViewsShown], None]) -> None:
        """Report ten times a second until the end."""
        before_ns = time.monotonic_ns()
        while not self._ended.wait(REPORT_S):
            now_ns = time.monotonic_ns()
            self.own_ns, before_ns = self.own_ns + (now_ns - before_ns) * (1.0 + self.rate), now_ns
            newest, lease = self._newest, pair.state.lease
            if newest is None or lease is None:
                continue
            age_ms = (now_ns - newest.capture_ns) / NS_PER_MS
            came = ViewCame(seq=newest.seq, age_ms=age_ms, fps=30.0)
            view = ViewShown(seq=newest.seq, capture_ns=newest.capture_ns, age_ms=age_ms, fps=30.0, came=came)
            own_ns, views = round(self.own_ns), {newest.camera: view}
            put(ViewsShown(session=7, sent_ns=own_ns, lease=lease.number, h264=False, views=views))


@contextmanager
def _console(pair: CellPair) -> Iterator[_Console]:
    """A console of the operator at the video endpoint."""
    console, setup = _Console(), pair.setup
    with open_link(connect=(setup.endpoints.video,), security=setup.security, sessions=(ChannelSession.VIDEO,)) as link:
        frames, shown = link.latest(CAMERA, CELL, CAMERA_NAME), link.publisher(SHOWN, CELL, operator=OPERATOR)
        threads = [
            threading.Thread(target=frames.feed, args=(console.take,), daemon=True),
            threading.Thread(target=console.report, args=(pair, shown.put), daemon=True),
        ]
        for thread in threads:
            thread.start()
        try:
            yield console
        finally:
            console.end()
            threads[1].join()
