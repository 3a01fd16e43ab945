"""The recorder of a cell: it keeps what the site leaves, bounds it into episodes, and shows what it does."""

from collections.abc import Callable
from contextlib import suppress
from datetime import datetime

import structlog

from common.clock import NS_PER_MS
from common.errors import RecordingError
from common.messages.recording import RecordingState
from common.messages.requests import RecordAction
from common.messages.robot import SessionState
from common.recording.config import StartPolicy
from common.recording.episodes import EpisodeEvent, Episodes
from common.recording.session import RecordingPlan, RecordingSession
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.records import FullPicture, Kept, PassedMessage, RecordedTick, RecordOrder
from remote_site.recording.transcript import Transcript

STATUS_NS = 200 * NS_PER_MS
FOLLOWING = (SessionState.ENGAGED, SessionState.HOLDING)


class CellRecorder:
    """Keeps what the site leaves: at once, or once the lease's holder asks for it; a full disk ends that with an alarm.

    `date` gives the date of a recording's beginning.
    """

    def __init__(
        self, config: RemoteConfig, plan: RecordingPlan, site: SiteAttachment, date: Callable[[], datetime]
    ) -> None:
        self._config, self._plan, self._site, self._date = config, plan, site, date
        self._model = load_arm(config.robot)[0]
        self._wanted = config.record.start is StartPolicy.AT_ONCE
        self._session: RecordingSession | None = None
        self._transcript = Transcript(config, self._model)
        self._episodes = Episodes(config.record.episodes, config.record.task)
        self._alarm = ""
        self._told_ns = 0

    def step(self, now_ns: int) -> None:
        """Attach, obey, keep what has come, flush, and tell."""
        if not self._site.attend(now_ns):
            self.end(now_ns)
            return
        for order in self._site.orders():
            self._obey(order, now_ns)
        if self._wanted and self._session is None:
            self._guarded(lambda: self._begin(now_ns))
        self._guarded(lambda: self._keep(now_ns))
        if now_ns - self._told_ns >= STATUS_NS:
            self._told_ns = now_ns
            self._site.tell(self.state())

    def end(self, now_ns: int) -> None:
        """End the recording under way in order."""
        session = self._session
        if session is not None:
            self._guarded(lambda: self._finish(session, now_ns))
        self._session = None

    @property
    def lost(self) -> int:
        """What is missing in the recording: cycles, or records of any kind that were overwritten."""
        return max(self._site.lost, self._transcript.missing)

    def state(self) -> RecordingState:
        """What the recorder does."""
        episodes = self._episodes
        return RecordingState(
            writing=self._session is not None,
            on_request=self._config.record.start is StartPolicy.ON_REQUEST,
            operator_pictures=False,
            episode=episodes.number,
            episode_open=episodes.is_open,
            task=episodes.shown_task,
            outcome=episodes.outcome,
            lost=self.lost,
            alarm=self._alarm,
        )

    def _obey(self, order: RecordOrder, now_ns: int) -> None:
        match order.action:
            case RecordAction.START:
                self._wanted, self._alarm = True, ""
            case RecordAction.STOP:
                self._wanted = False
                self.end(now_ns)
            case _ if self._session is not None:
                given = order.task, order.outcome, order.note
                self._events(self._episodes.act(order.action, order.operator, now_ns, *given))

    def _begin(self, now_ns: int) -> None:
        record = self._config.record
        self._site.skip()
        self._episodes = Episodes(record.episodes, self._episodes.task or record.task)
        self._transcript = Transcript(self._config, self._model)
        self._session = RecordingSession(self._plan, self._date(), now_ns, self._transcript.preamble)
        structlog.get_logger().info("recording", file=str(self._session.path))

    def _keep(self, now_ns: int) -> None:
        for kept in self._site.records():
            if self._session is not None:
                self._write(self._session, kept)
        if self._session is not None:
            self._session.tend(now_ns)

    def _write(self, session: RecordingSession, kept: Kept) -> None:
        match kept:
            case RecordedTick():
                outcome = self._transcript.tick(session, kept)
                if outcome is not None:
                    engaged = outcome.state in FOLLOWING
                    self._events(self._episodes.follow(engaged=engaged, t_ns=kept.t_ns))
            case PassedMessage():
                self._transcript.message(session, kept)
            case FullPicture():
                self._transcript.picture(session, kept)

    def _events(self, events: list[EpisodeEvent]) -> None:
        for event in events:
            if self._session is not None:
                self._transcript.episode(self._session, event)

    def _finish(self, session: RecordingSession, now_ns: int) -> None:
        self._keep(now_ns)
        self._events(self._episodes.finish(now_ns))
        session.end()
        structlog.get_logger().info("recorded", file=str(session.path), lost=self.lost)

    def _guarded(self, write: Callable[[], None]) -> None:
        """Write; where nothing more can be written, end the recording with an alarm."""
        try:
            write()
        except (OSError, RecordingError) as error:
            why = f"{error.strerror}; free some space, and start it again" if isinstance(error, OSError) else str(error)
            session, self._session, self._wanted = self._session, None, False
            self._alarm = f"recording has ended: {why}"
            structlog.get_logger().error("recording has ended", reason=why)
            if session is not None:
                with suppress(RecordingError, OSError):  # the disk may be too full for the index, too
                    session.abandon()
