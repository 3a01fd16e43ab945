"""Control's end of the recording: each tick and each message into the ring, only while a recorder is there."""

from itertools import islice

from common.clock import Clock
from common.errors import MessageError
from common.messages.recording import EpisodeOutcome, RecordingState
from common.process.log import RefusalLog
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import RobotReport
from remote_site.recording.cycle_record import encode_input, encode_outcome, outcome_of
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.message_budget import MessageBudget
from remote_site.recording.records import ENCODER, PassedMessage, RecordedTick, RecordOrder, decode_state
from remote_site.shared_ring import RingReader
from remote_site.teleop.cycle import Command, CycleInput

STATES_PER_LOOK = 400  # more than the ring holds of them
# What is told of a recorder that is there and cannot be understood: it may be recording, and every page has to know.
UNREADABLE = RecordingState(
    writing=True,
    on_request=False,
    operator_pictures=False,
    episode=0,
    episode_open=False,
    task="",
    outcome=EpisodeOutcome.UNKNOWN,
    lost=0,
    alarm="a recorder is there whose state cannot be read: end it, and start farhand record of this site's release",
)


class ControlTap:
    """Fills the ring of ticks; nothing of it waits, and messages are written behind the tick's command.

    `note_message` is the tap of control's link. Ticks are numbered from 1, whether or not somebody records.
    """

    def __init__(self, memory: RecordingMemory, clock: Clock) -> None:
        self._memory, self._clock = memory, clock
        self._status = RingReader(memory.status)
        self._state: RecordingState | None = None
        self._refusals = RefusalLog("a recorder's state is refused")
        self._budget = MessageBudget()
        self._messages: list[tuple[PassedMessage, bool]] = []  # and whether it was refused
        self._ticks = 0
        self._is_watched = memory.has_recorder(clock.now_ns())

    def note_message(self, key: str, payload: bytes, *, sent: bool, refused: bool = False) -> None:
        """A message has passed control's link."""
        if self._is_watched:
            self._messages.append((PassedMessage(key, self._clock.now_ns(), sent, payload), refused))

    def note_cycle(
        self, given: CycleInput, command: Command, ordered: JointCommand | None, report: RobotReport
    ) -> None:
        """A cycle's command was sent: `ordered` to the driver's process, after its `report`."""
        self._ticks += 1
        self._is_watched = self._memory.has_recorder(given.now_ns)
        if not self._is_watched:
            self._messages.clear()
            return
        outcome = outcome_of(self._ticks, command, ordered, report)
        tick = RecordedTick(given.now_ns, encode_input(given), encode_outcome(outcome))
        self._memory.ticks.write(ENCODER.encode(tick))
        holder = given.lease.lease.holder.name if given.lease.lease is not None else ""
        for message, refused in self._messages:
            if self._budget.keeps(message, holder, refused=refused):
                self._memory.ticks.write(ENCODER.encode(message))
        self._messages.clear()
        for left_out in self._budget.take_left_out(given.now_ns):
            self._memory.ticks.write(ENCODER.encode(left_out))

    def order(self, order: RecordOrder) -> None:
        """Hand the recorder what the lease's holder asks of it."""
        self._memory.requests.write(ENCODER.encode(order))

    def state(self, now_ns: int) -> RecordingState | None:
        """Return what the recorder does; None while none is there."""
        told = list(islice(iter(self._status.take, None), STATES_PER_LOOK))
        if told:
            self._state = self._decoded(told[-1])
        return self._state if self._memory.has_recorder(now_ns) else None

    def _decoded(self, data: bytes) -> RecordingState:
        try:
            return decode_state(data)
        except MessageError as error:
            self._refusals.note(error)
            return UNREADABLE
