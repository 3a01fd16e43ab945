"""What goes through the rings between the site's processes and its recorder, as bytes and back."""

import msgspec

from common.messages.recording import EpisodeOutcome, RecordingState
from common.messages.requests import RecordAction


class RecordedTick(msgspec.Struct, frozen=True, array_like=True, tag="tick"):
    """A control cycle: its time, its input and its outcome as bytes."""

    t_ns: int
    given: bytes
    outcome: bytes


class PassedMessage(msgspec.Struct, frozen=True, array_like=True, tag="passed"):
    """A message as it passed the wire at `t_ns`, `sent` by this site or received."""

    key: str
    t_ns: int
    sent: bool
    payload: bytes


class FullPicture(msgspec.Struct, frozen=True, array_like=True, tag="picture"):
    """A JPEG of a camera in full quality, as exposed at `capture_ns`."""

    camera: str
    capture_ns: int
    capture_estimated: bool
    width: int
    height: int
    data: bytes


class RecordOrder(msgspec.Struct, frozen=True, array_like=True):
    """What the lease's holder asks of the recorder."""

    action: RecordAction
    operator: str
    task: str = ""
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN
    note: str = ""


Kept = RecordedTick | PassedMessage | FullPicture
ENCODER = msgspec.msgpack.Encoder()
KEPT = msgspec.msgpack.Decoder(Kept)
ORDERS = msgspec.msgpack.Decoder(RecordOrder)
STATES = msgspec.msgpack.Decoder(RecordingState)
