"""Records that go through the rings between the site's processes and its recorder, as bytes and back."""

import msgspec

from common.errors import MessageError
from common.messages.base import MOST_TEXT
from common.messages.recording import EpisodeOutcome, RecordingState
from common.messages.requests import RecordAction
from common.text import cut


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


class LeftOut(msgspec.Struct, frozen=True, array_like=True, tag="left_out"):
    """The messages of an operator, and their bytes, that were not recorded until `t_ns`, since this was last reported.

    The operator is empty where keys name none.
    """

    t_ns: int
    operator: str
    messages: int
    size: int


class RecordOrder(msgspec.Struct, frozen=True, array_like=True):
    """An order of the lease's holder to the recorder."""

    action: RecordAction
    operator: str
    task: str = ""
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN
    note: str = ""


Kept = RecordedTick | PassedMessage | FullPicture | LeftOut
ENCODER = msgspec.msgpack.Encoder()
KEPT = msgspec.msgpack.Decoder(Kept)
ORDERS = msgspec.msgpack.Decoder(RecordOrder)
STATES = msgspec.msgpack.Decoder(dict[str, object])


def decode_state(data: bytes) -> RecordingState:
    """Decode what a recorder wrote of itself; MessageError for anything else.

    A recorder of the next release may tell more: what it adds is left out, and text is cut to what a message holds.
    """
    try:
        told = STATES.decode(data)
        known = {name: told[name] for name in RecordingState.__struct_fields__ if name in told}
        short = {name: cut(value, MOST_TEXT) if isinstance(value, str) else value for name, value in known.items()}
        return msgspec.convert(short, RecordingState)
    except (msgspec.DecodeError, ValueError, RecursionError) as error:
        raise MessageError("invalid", f"no state of a recorder: {error}") from error
