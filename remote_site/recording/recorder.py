"""The recorder of a cell: keeps what the site leaves, bounds it into episodes, shows what it does; and its loop."""

import threading
import time
from collections.abc import Callable
from datetime import datetime
from functools import partial

import structlog

from common.clock import NS_PER_MS
from common.messages.recording import RecordingState
from common.messages.robot import FOLLOWING
from common.process.service import StopFlag, notify
from common.recording.asked_recording import AskedRecording
from common.recording.awaited_site import AwaitedSite
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingPlan, RecordingSession
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.memory_files import memory_place
from remote_site.recording.records import FullPicture, Kept, LeftOut, PassedMessage, RecordedTick
from remote_site.recording.transcript import Transcript

STATUS_NS = 200 * NS_PER_MS
POLL_S = 0.05
BEAT_S = 0.25


class CellRecorder:
    """Keeps what the site leaves, at once or once the lease's holder asks for it; a full disk ends it with an alarm."""

    def __init__(self, config: RemoteConfig, recording: GuardedRecording, site: SiteAttachment) -> None:
        self._config, self._site = config, site
        self._recording = AskedRecording(config.record, recording)
        self._model = load_arm(config.robot)[0]
        self._transcript = Transcript(config, self._model)
        self._told_ns = 0
        links = config.links
        self._awaited = AwaitedSite("remote", config.cell, links.control or links.router)

    def step(self, now_ns: int) -> None:
        """Attach, obey, keep what has come, flush, and tell."""
        recording = self._recording
        is_there = self._site.attend(now_ns)
        self._awaited.note(is_there=is_there)
        if not is_there:
            self.end(now_ns)
            recording.forget_requests()
            return
        for order in self._site.orders():
            recording.obey(order.action, order.operator, now_ns, order.task, order.outcome, order.note)
        if recording.is_due:
            self._begin(now_ns)
        elif recording.is_over:
            self.end(now_ns)
        self._keep()
        recording.tend(now_ns)
        if now_ns - self._told_ns >= STATUS_NS:
            self._told_ns = now_ns
            self._site.tell(self.state())

    def end(self, now_ns: int) -> None:
        """End the recording under way in order, with what has come until now."""
        if self._recording.is_writing:
            self._keep()
            self._recording.end(now_ns)

    @property
    def lost(self) -> int:
        """The number of missing cycles, or of records of any kind that were overwritten."""
        return max(self._site.lost, self._transcript.missing)

    def state(self) -> RecordingState:
        """Return what the recorder does."""
        return self._recording.state(self.lost)

    def _begin(self, now_ns: int) -> None:
        if self._recording.is_on_request:
            self._site.skip()
        self._transcript = Transcript(self._config, self._model)
        self._recording.begin(self._transcript.preamble, now_ns)

    def _keep(self) -> None:
        for kept in self._site.records():
            self._recording.write(partial(self._write, kept=kept))

    def _write(self, session: RecordingSession, kept: Kept) -> None:
        match kept:
            case RecordedTick():
                outcome = self._transcript.tick(session, kept)
                if outcome is not None:
                    self._recording.follow(session, engaged=outcome.state in FOLLOWING, t_ns=kept.t_ns)
            case PassedMessage():
                self._transcript.message(session, kept)
            case FullPicture():
                self._transcript.picture(session, kept)
            case LeftOut():
                self._transcript.left_out(session, kept)


def record_cell(config: RemoteConfig, plan: RecordingPlan, date: Callable[[], datetime], should_stop: StopFlag) -> None:
    """Record the site of this configuration until asked to stop, whenever it runs."""
    site, ended = SiteAttachment(memory_place(config.cell, config.links)), threading.Event()
    recorder = CellRecorder(config, GuardedRecording(plan, date), site)
    beats = threading.Thread(target=_beat, args=(site, ended), name="beat", daemon=True)
    beats.start()
    notify("READY=1")
    structlog.get_logger().info("ready", cell=config.cell)
    try:
        while not should_stop():
            recorder.step(time.monotonic_ns())
            notify("WATCHDOG=1")
            should_stop.wait(POLL_S)
        notify("STOPPING=1")
        recorder.end(time.monotonic_ns())
    finally:
        ended.set()
        beats.join()
        site.close()


def _beat(site: SiteAttachment, ended: threading.Event) -> None:
    """Beat while a step waits for a busy disk: meanwhile the rings fill, and nothing is lost."""
    while not ended.wait(BEAT_S):
        site.beat(time.monotonic_ns())
