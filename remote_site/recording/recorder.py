"""The recorder of a cell: it keeps what the site leaves, bounds it into episodes, and shows what it does."""

from functools import partial

from common.clock import NS_PER_MS
from common.messages.recording import RecordingState
from common.messages.robot import FOLLOWING
from common.recording.asked_recording import AskedRecording
from common.recording.awaited_site import AwaitedSite
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingSession
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.records import FullPicture, Kept, LeftOut, PassedMessage, RecordedTick
from remote_site.recording.transcript import Transcript

STATUS_NS = 200 * NS_PER_MS


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
