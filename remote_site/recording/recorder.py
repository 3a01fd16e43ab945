"""The recorder of a cell: it keeps what the site leaves, bounds it into episodes, and shows what it does."""

from functools import partial

from common.clock import NS_PER_MS
from common.messages.recording import RecordingState
from common.messages.requests import RecordAction
from common.messages.robot import SessionState
from common.recording.config import StartPolicy
from common.recording.episodes import EpisodeEvent, Episodes
from common.recording.guarded import GuardedRecording
from common.recording.hand_transcript import add_episode
from common.recording.session import RecordingSession
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.records import FullPicture, Kept, PassedMessage, RecordedTick, RecordOrder
from remote_site.recording.transcript import Transcript

STATUS_NS = 200 * NS_PER_MS
FOLLOWING = (SessionState.ENGAGED, SessionState.HOLDING)


class CellRecorder:
    """Keeps what the site leaves, at once or once the lease's holder asks for it; a full disk ends it with an alarm."""

    def __init__(self, config: RemoteConfig, recording: GuardedRecording, site: SiteAttachment) -> None:
        self._config, self._recording, self._site = config, recording, site
        self._model = load_arm(config.robot)[0]
        self._is_at_once = config.record.start is StartPolicy.AT_ONCE
        self._wanted = self._is_at_once
        self._transcript = Transcript(config, self._model)
        self._episodes = Episodes(config.record.episodes, config.record.task)
        self._told_ns = 0

    def step(self, now_ns: int) -> None:
        """Attach, obey, keep what has come, flush, and tell."""
        if not self._site.attend(now_ns):
            self.end(now_ns)
            self._wanted = self._is_at_once  # what was asked of one run of the site is not of the next
            return
        for order in self._site.orders():
            self._obey(order, now_ns)
        recording = self._recording
        if self._wanted and recording.session is None and not recording.alarm:
            self._begin(now_ns)
        self._keep()
        recording.write(lambda session: session.tend(now_ns))
        if now_ns - self._told_ns >= STATUS_NS:
            self._told_ns = now_ns
            self._site.tell(self.state())

    def end(self, now_ns: int) -> None:
        """End the recording under way in order, with what has come until now."""
        if self._recording.session is not None:
            self._keep()
            self._recording.end(lambda session: self._events(session, self._episodes.finish(now_ns)))

    @property
    def lost(self) -> int:
        """What is missing in the recording: cycles, or records of any kind that were overwritten."""
        return max(self._site.lost, self._transcript.missing)

    def state(self) -> RecordingState:
        """What the recorder does."""
        episodes = self._episodes
        return RecordingState(
            writing=self._recording.session is not None,
            on_request=not self._is_at_once,
            operator_pictures=False,
            episode=episodes.number,
            episode_open=episodes.is_open,
            task=episodes.shown_task,
            outcome=episodes.outcome,
            lost=self.lost,
            alarm=self._recording.alarm,
        )

    def _obey(self, order: RecordOrder, now_ns: int) -> None:
        match order.action:
            case RecordAction.START:
                self._wanted, self._recording.alarm = True, ""
            case RecordAction.STOP:
                self._wanted = False
                self.end(now_ns)
            case _ if self._recording.session is not None:
                given = order.task, order.outcome, order.note
                events = self._episodes.act(order.action, order.operator, now_ns, *given)
                self._recording.write(lambda session: self._events(session, events))

    def _begin(self, now_ns: int) -> None:
        record = self._config.record
        if not self._is_at_once:
            self._site.skip()
        self._episodes = Episodes(record.episodes, self._episodes.task or record.task)
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
                    engaged = outcome.state in FOLLOWING
                    self._events(session, self._episodes.follow(engaged=engaged, t_ns=kept.t_ns))
            case PassedMessage():
                self._transcript.message(session, kept)
            case FullPicture():
                self._transcript.picture(session, kept)

    def _events(self, session: RecordingSession, events: list[EpisodeEvent]) -> None:
        for event in events:
            add_episode(session, event)
