"""One MCAP file that grows by whole chunks with each flush: whatever ends it loses no more than what came since."""

import fcntl
import os
from collections import Counter
from pathlib import Path
from typing import IO, Any, NamedTuple

import structlog
from mcap.writer import CompressionType, Writer

from common.atomic_file import OWNER_ONLY
from common.recording.topics import ChunkGroup, MessageSchema, Topic

MOST_CHUNK_BYTES = 16 << 20  # two seconds of four cameras: flushes make the chunks, not their size
MOST_TOPICS_BYTES = 256 << 10  # of names and schemas; a site's own are some 50 kB, and a reader takes 1 MB
SHOWN_NAME = 80


class TakenTopics:
    """As many topics as MOST_TOPICS_BYTES describe, the first that come; the log says the first that is left out.

    Without a list of operators anybody on a host could invent names without end.
    """

    def __init__(self, file: Path) -> None:
        self._file = file
        self._names = set[str]()
        self._schemas = set[MessageSchema]()
        self._bytes = 0
        self._is_full = False

    def take(self, topic: Topic) -> bool:
        """Add a topic that the file does not have yet; return False where it has no room for it."""
        if topic.name in self._names:
            return True
        size = topic.named_bytes + (0 if topic.schema in self._schemas else topic.schema.described_bytes)
        if self._bytes + size > MOST_TOPICS_BYTES:
            self._say(topic)
            return False
        self._bytes += size
        self._names.add(topic.name)
        self._schemas.add(topic.schema)
        return True

    def _say(self, topic: Topic) -> None:
        if self._is_full:
            return
        self._is_full = True
        reason = f"it has {len(self._names)}; messages of further ones are left out; a list links.operators bounds them"
        said = {"file": str(self._file), "first": topic.name[:SHOWN_NAME], "reason": reason}
        structlog.get_logger().warning("a recording takes no more topics", **said)


class FileOutput:
    """An unbuffered file, its owner's alone, that counts what was written; OSError where nothing more can be."""

    def __init__(self, path: Path) -> None:
        self._handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, OWNER_ONLY)
        fcntl.flock(self._handle, fcntl.LOCK_EX)  # nobody repairs a file that is being written
        self.size = 0

    def write(self, data: bytes) -> int:
        """Write all of it."""
        left = memoryview(data)
        while left:
            written = os.write(self._handle, left)
            self.size += written
            left = left[written:]
        return len(data)

    def tell(self) -> int:
        return self.size

    def flush(self) -> None:
        """Do nothing: what was written is the kernel's already."""

    def sync(self) -> None:
        """Have it on the disk too, so that a power cut loses no more."""
        os.fdatasync(self._handle)

    def close(self) -> None:
        os.close(self._handle)


def is_being_written(file: IO[bytes]) -> bool:
    """Return whether a recorder has this file open; else no recorder changes it as long as `file` is open."""
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    return False


class WaitingMessage(NamedTuple):
    """A message that is not in the file yet, with its number in its topic; times in ns since the file's epoch."""

    topic: Topic
    number: int
    data: bytes
    log_ns: int
    published_ns: int


class McapFile:
    """Topics and messages into one new file; FileExistsError where there is one.

    OSError of any call means that no more can be written: close the file, and repair it.
    """

    def __init__(self, path: Path, software: str) -> None:
        self.path = path
        self._output = FileOutput(path)
        output: Any = self._output
        self._writer: Any = Writer(output, chunk_size=MOST_CHUNK_BYTES, compression=CompressionType.LZ4)
        self._topics = TakenTopics(path)
        self._schemas: dict[MessageSchema, int] = {}
        self._channels: dict[str, int] = {}
        self._counts = Counter[str]()
        self._waiting: dict[ChunkGroup, list[WaitingMessage]] = {group: [] for group in ChunkGroup}
        self._waiting_bytes = 0
        self._writer.start(profile="farhand", library=software)

    @property
    def size(self) -> int:
        """The bytes in the file, without those since the last flush."""
        return self._output.size

    def describe(self, name: str, table: dict[str, str]) -> None:
        """Add a table of words about the recording."""
        self._writer.add_metadata(name, table)

    def attach(self, name: str, media_type: str, data: bytes, log_ns: int) -> None:
        """Add a document."""
        self._writer.add_attachment(create_time=log_ns, log_time=log_ns, name=name, media_type=media_type, data=data)

    def add(self, topic: Topic, data: bytes, log_ns: int, published_ns: int) -> None:
        """Append a message; times in ns since the epoch of the file. It is left out where its topic finds no room."""
        if not self._topics.take(topic):
            return
        self._waiting[topic.group].append(WaitingMessage(topic, self._counts[topic.name], data, log_ns, published_ns))
        self._counts[topic.name] += 1
        self._waiting_bytes += len(data)
        if self._waiting_bytes >= MOST_CHUNK_BYTES:
            self._write_waiting()

    def flush(self) -> None:
        """End the chunks: from now on the messages so far survive whatever happens."""
        self._write_waiting()
        self._output.sync()

    def finish(self) -> None:
        """Write the index and close."""
        self._write_waiting()
        self._writer.finish()
        self._output.sync()
        self.close()

    def close(self) -> None:
        """Close the file as it is."""
        self._output.close()

    def _write_waiting(self) -> None:
        """Each group into a chunk of its own."""
        for messages in self._waiting.values():
            for topic, number, data, log_ns, published_ns in messages:
                if topic.name not in self._channels:
                    self._channels[topic.name] = self._register(topic)
                self._writer.add_message(self._channels[topic.name], log_ns, data, published_ns, number)
            messages.clear()
            self._writer.flush()
        self._waiting_bytes = 0

    def _register(self, topic: Topic) -> int:
        schema = topic.schema
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(schema.name, schema.encoding, schema.data)
        channel: int = self._writer.register_channel(topic.name, topic.encoding, self._schemas[schema], topic.about)
        return channel
