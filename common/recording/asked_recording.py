"""A recording with its episodes: begun at once, or by whoever may ask for it."""

from common.clock import NS_PER_S
from common.messages.recording import EpisodeOutcome, RecordingState
from common.messages.requests import RecordAction
from common.recording.config import RecordConfig, StartPolicy
from common.recording.episodes import EpisodeEvent, Episodes
from common.recording.guarded import GuardedRecording, Write
from common.recording.hand_transcript import add_episode
from common.recording.session import Preamble, RecordingSession


class AskedRecording:
    """The part that both sites' recorders share; a recording that ended with an alarm waits for the next request."""

    def __init__(self, config: RecordConfig, recording: GuardedRecording, *, operator_pictures: bool = False) -> None:
        self._config, self._recording, self._operator_pictures = config, recording, operator_pictures
        self._wanted = not self.is_on_request
        self._episodes = Episodes(config.episodes, config.task)
        self._now_ns = 0

    @property
    def is_on_request(self) -> bool:
        """Return whether nothing is recorded until it is asked for."""
        return self._config.start is StartPolicy.ON_REQUEST

    @property
    def is_writing(self) -> bool:
        """Return whether a recording is under way."""
        return self._recording.session is not None

    @property
    def is_due(self) -> bool:
        """Return whether a recording has to begin now."""
        return self._wanted and not self.is_writing and not self._recording.alarm

    @property
    def is_over(self) -> bool:
        """Return whether the recording under way has to end now."""
        return self.is_writing and not self._wanted

    def begin(self, preamble: Preamble, now_ns: int) -> None:
        """Begin; `preamble` writes what each of its files has to contain. Episodes count from 1 again."""
        self._episodes = Episodes(self._config.episodes, self._episodes.task or self._config.task)
        self._recording.begin(preamble, now_ns)

    def obey(self, action: RecordAction, by: str, now_ns: int, task: str, outcome: EpisodeOutcome, note: str) -> None:
        """Take an operator's request; a begin or an end is due then, and the recorder carries it out."""
        if action is RecordAction.START:
            self._wanted, self._recording.alarm = True, ""
        elif action is RecordAction.STOP:
            self._wanted = False
        elif self.is_writing:
            events = self._episodes.act(action, by, now_ns, task, outcome, note)
            self.write(lambda session: _add(session, events))

    def forget_requests(self) -> None:
        """The site has ended: what was asked of one run of it is not of the next."""
        self._wanted = not self.is_on_request

    def follow(self, session: RecordingSession, *, engaged: bool, t_ns: int) -> None:
        """Note whether the arm is engaged at this time, a short hold included."""
        _add(session, self._episodes.follow(engaged=engaged, t_ns=t_ns))

    def write(self, write: Write) -> None:
        """Write to the recording under way, if there is one."""
        self._recording.write(write)

    def tend(self, now_ns: int) -> None:
        """See to the files of the recording under way, and note the time, by which `state` tells how long it is."""
        self._now_ns = now_ns
        self.write(lambda session: session.tend(now_ns))

    def end(self, now_ns: int) -> None:
        """End the recording under way in order, if there is one."""
        if self.is_writing:
            self._recording.end(lambda session: _add(session, self._episodes.finish(now_ns)))

    def state(self, lost: int) -> RecordingState:
        """Return the recorder's state; `lost` counts what it was too slow to take."""
        episodes, session = self._episodes, self._recording.session
        return RecordingState(
            writing=self.is_writing,
            on_request=self.is_on_request,
            operator_pictures=self._operator_pictures,
            episode=episodes.number,
            episode_open=episodes.is_open,
            task=episodes.shown_task,
            outcome=episodes.outcome,
            lost=lost,
            alarm=self._recording.alarm,
            seconds=max(0, self._now_ns - session.began_ns) / NS_PER_S if session is not None else 0.0,
            size_bytes=session.size_bytes if session is not None else 0,
            episode_seconds=episodes.lasted_ns(self._now_ns) / NS_PER_S,
        )


def _add(session: RecordingSession, events: list[EpisodeEvent]) -> None:
    for event in events:
        add_episode(session, event)
