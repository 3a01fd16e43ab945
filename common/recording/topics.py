"""A topic of a recording: its encoding, its schema, and what a reader should know of it."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import msgspec
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.Log_pb2 import Log
from mcap_protobuf.schema import build_file_descriptor_set

from common.recording.episodes import EpisodeEvent

PROTOBUF, JSON, MSGPACK = "protobuf", "json", "msgpack"
OWN = "farhand."


class ChunkGroup(Enum):
    """Which topics share chunks: who looks for messages of one group reads nothing of the others.

    Events are few, and looked for over whole files.
    """

    EVENTS = 0
    SIGNALS = 1
    PICTURES = 2


GROUPS = {
    Log.DESCRIPTOR.full_name: ChunkGroup.EVENTS,
    f"{OWN}{EpisodeEvent.__name__}": ChunkGroup.EVENTS,
    CompressedImage.DESCRIPTOR.full_name: ChunkGroup.PICTURES,
}


@dataclass(frozen=True, slots=True)
class MessageSchema:
    """The schema of a topic's messages; without `encoding` it is only a name."""

    name: str
    encoding: str = ""
    data: bytes = b""

    @property
    def described_bytes(self) -> int:
        """The bytes that it takes in a file."""
        return len(f"{self.name}{self.encoding}".encode()) + len(self.data)


@dataclass(frozen=True, slots=True)
class Topic:
    """A stream of messages of one kind in a file; `about` are words and numbers that a reader needs."""

    name: str
    encoding: str
    schema: MessageSchema
    about: dict[str, str] = field(default_factory=dict)

    @property
    def group(self) -> ChunkGroup:
        """With which topics it shares chunks."""
        return GROUPS.get(self.schema.name, ChunkGroup.SIGNALS)

    @property
    def named_bytes(self) -> int:
        """The bytes that its name and words take in a file."""
        words = (self.name, self.encoding, *self.about, *self.about.values())
        return sum(len(word.encode()) for word in words)


def protobuf_topic(name: str, message: Any, **about: str) -> Topic:
    """A topic of a protobuf class, with all that its file descriptors depend on."""
    descriptors = build_file_descriptor_set(message).SerializeToString()
    return Topic(name, PROTOBUF, MessageSchema(message.DESCRIPTOR.full_name, PROTOBUF, descriptors), about)


def json_topic(name: str, struct: type[msgspec.Struct], **about: str) -> Topic:
    """A topic whose messages are this struct as JSON, with its JSON schema."""
    (reference,), components = msgspec.json.schema_components([struct], ref_template="#/$defs/{name}")
    whole = components.pop(struct.__name__, reference) | {"$defs": components}
    schema = MessageSchema(f"{OWN}{struct.__name__}", "jsonschema", msgspec.json.encode(whole))
    return Topic(name, JSON, schema, about)


def wire_topic(key: str, message: str, version: int, **about: str) -> Topic:
    """A topic of messages as they pass the wire under this key."""
    return Topic(key, MSGPACK, MessageSchema(f"{OWN}{message}.v{version}"), about)
