"""What is kept under one name in a recording: its encoding, its schema, and what a reader should know of it."""

from dataclasses import dataclass, field
from typing import Any

import msgspec
from mcap_protobuf.schema import build_file_descriptor_set

PROTOBUF, JSON, MSGPACK = "protobuf", "json", "msgpack"


@dataclass(frozen=True, slots=True)
class MessageSchema:
    """The schema of a topic's messages; without `encoding` it is only a name."""

    name: str
    encoding: str = ""
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class Topic:
    """A stream of messages of one kind in a file; `about` are words and numbers that a reader needs."""

    name: str
    encoding: str
    schema: MessageSchema
    about: dict[str, str] = field(default_factory=dict)


def protobuf_topic(name: str, message: Any, **about: str) -> Topic:
    """A topic of a protobuf class, with all that its file descriptors depend on."""
    descriptors = build_file_descriptor_set(message).SerializeToString()
    return Topic(name, PROTOBUF, MessageSchema(message.DESCRIPTOR.full_name, PROTOBUF, descriptors), about)


def json_topic(name: str, struct: type[msgspec.Struct], **about: str) -> Topic:
    """A topic whose messages are this struct as JSON, with its JSON schema."""
    (reference,), components = msgspec.json.schema_components([struct], ref_template="#/$defs/{name}")
    whole = components.pop(struct.__name__, reference) | {"$defs": components}
    return Topic(
        name, JSON, MessageSchema(f"farhand.{struct.__name__}", "jsonschema", msgspec.json.encode(whole)), about
    )


def wire_topic(key: str, message: str, version: int, **about: str) -> Topic:
    """A topic of messages as they pass the wire under this key."""
    return Topic(key, MSGPACK, MessageSchema(f"farhand.{message}.v{version}"), about)
