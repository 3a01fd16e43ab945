"""Video's end of the recording: pictures in full quality, and each message, only while a recorder is there."""

import msgspec

from common.cameras.camera import Frame
from common.clock import Clock
from common.link.channels import CAMERA
from common.messages.codec import encode
from common.messages.video import VideoFrame
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.message_budget import MessageBudget
from remote_site.recording.records import ENCODER, FullPicture, PassedMessage


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
