"""What other programs and other hosts' clocks do beside an arm that follows: a strange recorder, a slewed clock."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import msgspec

from common.clock import NS_PER_MS
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
    """The clock of the operator's host gains 8 %, then loses them: the arm follows, video and site live."""
    pair = trial.pair
    pair.move()
    with _console(pair) as console:
        pair.wait("pictures", lambda: console.came, 10)
        trial.begin(lambda _: None)
        for rate in (SLEW, -SLEW):
            pair.hand(slew=rate)
            console.rate = rate
            time.sleep(SLEWED_S)
        trial.follows(0.95)
        came = console.came
        pair.wait("more pictures", lambda: console.came > came + 10, 5)
        trial.note(f"{console.came} pictures came")
    trial.check(pair.remote.exit_code is None, "the site has ended")
    pair.start_local()  # its clock is the machine's again


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
