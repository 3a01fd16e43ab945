"""Control's end of the recording: each tick and each message into the ring, only while a recorder is there."""

from common.clock import Clock
from common.messages.recording import RecordingState
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import RobotReport
from remote_site.recording.cycle_record import encode_input, encode_outcome, outcome_of
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.records import ENCODER, STATES, PassedMessage, RecordedTick, RecordOrder
from remote_site.shared_ring import RingReader
from remote_site.teleop.cycle import Command, CycleInput


class ControlTap:
    """Fills the ring of ticks; nothing of it waits, and messages are written behind the tick's command.

    `note_message` is the tap of control's link. Ticks are numbered from 1, whether or not somebody records.
    """

    def __init__(self, memory: RecordingMemory, clock: Clock) -> None:
        self._memory, self._clock = memory, clock
        self._status = RingReader(memory.status)
        self._state: RecordingState | None = None
        self._messages: list[PassedMessage] = []
        self._ticks = 0
        self._is_watched = memory.has_recorder(clock.now_ns())

    def note_message(self, key: str, payload: bytes, *, sent: bool) -> None:
        """A message has passed control's link."""
        if self._is_watched:
            self._messages.append(PassedMessage(key, self._clock.now_ns(), sent, payload))

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
        for message in self._messages:
            self._memory.ticks.write(ENCODER.encode(message))
        self._messages.clear()

    def order(self, order: RecordOrder) -> None:
        """Hand the recorder what the lease's holder asks of it."""
        self._memory.requests.write(ENCODER.encode(order))

    def state(self, now_ns: int) -> RecordingState | None:
        """What the recorder does, None while none is there."""
        while (newest := self._status.take()) is not None:
            self._state = STATES.decode(newest)
        return self._state if self._memory.has_recorder(now_ns) else None
