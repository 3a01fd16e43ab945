"""The site's ends of the recording, control's and video's: into rings what passes, only while a recorder is there."""

from itertools import islice

import msgspec

from common.cameras.camera import Frame
from common.clock import Clock
from common.errors import MessageError
from common.link.channels import CAMERA
from common.messages.codec import encode
from common.messages.recording import EpisodeOutcome, RecordingState
from common.messages.video import VideoFrame
from common.process.log import RefusalLog
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.link import RobotReport
from remote_site.recording.cycle_record import encode_input, encode_outcome, outcome_of
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.message_budget import MessageBudget
from remote_site.recording.records import ENCODER, FullPicture, PassedMessage, RecordedTick, RecordOrder, decode_state
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


class VideoTap:
    """Fills the ring of pictures; nothing of it waits.

    A frame that was sent with the very bytes of the full picture is kept without them: a reader finds them in the
    picture of the same camera and exposure.
    """

    def __init__(self, memory: RecordingMemory, cell: str, clock: Clock) -> None:
        self._memory, self._cell, self._clock = memory, cell, clock
        self._budget = MessageBudget()

    def is_watched(self) -> bool:
        """Return whether a recorder is there."""
        return self._memory.has_recorder(self._clock.now_ns())

    def note_message(self, key: str, payload: bytes, *, sent: bool, refused: bool = False) -> None:
        """The tap of video's link; frames come by `note_frame`."""
        if not self.is_watched() or (sent and "/camera/" in key):
            return
        message = PassedMessage(key, self._clock.now_ns(), sent, payload)
        if self._budget.keeps(message, holder="", refused=refused):
            self._memory.pictures.write(ENCODER.encode(message))

    def note_frame(self, frame: VideoFrame, *, is_full: bool) -> None:
        """A frame was sent; `is_full` if its bytes are those of the full picture."""
        kept = msgspec.structs.replace(frame, data=b"") if is_full else frame
        now_ns, key = self._clock.now_ns(), CAMERA.key_for(self._cell, frame.camera)
        for record in (PassedMessage(key, now_ns, True, encode(kept)), *self._budget.take_left_out(now_ns)):
            self._memory.pictures.write(ENCODER.encode(record))

    def keep(self, camera: str, frame: Frame, data: bytes) -> None:
        """An exposure of a camera, as a JPEG in full quality."""
        height, width = frame.image.shape[:2]
        picture = FullPicture(camera, frame.capture_ns, frame.capture_estimated, width, height, data)
        self._memory.pictures.write(ENCODER.encode(picture))
