"""A long recording out of a short one: its messages again and again, each round later by the length of a round."""

from collections.abc import Iterator
from datetime import datetime, timedelta
from pathlib import Path
from typing import NamedTuple

from mcap.reader import McapReader, make_reader
from mcap.records import Channel, Schema

from common.clock import NS_PER_MS, NS_PER_S
from common.recording.config import RecordConfig
from common.recording.reader import CLOCK_TABLE, RecordingReader
from common.recording.session import EPOCH, RecordingPlan, RecordingSession
from common.recording.topics import MessageSchema, Topic
from remote_site.recording.topics import image_topic

BETWEEN_NS = 4 * NS_PER_MS  # from the last message of a round to the first of the next


class Kept(NamedTuple):
    """A message of the short recording, its times by the clock of the host that recorded."""

    topic: Topic
    data: bytes
    t_ns: int
    published_ns: int


def first_pictures_ns(file: Path) -> dict[str, int]:
    """Read when each camera of a recording gave its first picture."""
    prefix = image_topic("").name
    with RecordingReader(file) as recording:
        kept = [name for name in recording.topics if name.startswith(prefix) and name.count("/") == 2]
        return {name.removeprefix(prefix): next(recording.messages([name])).t_ns for name in kept}


def write_long(short: Path, long: Path, seconds: float) -> None:
    """Write a new file of at least this length, by the recorders' own writer.

    The first round has all messages, the others those since all cameras gave pictures. Only the times by which messages
    are found are shifted; those within messages repeat.
    """
    steady_ns = max(first_pictures_ns(short).values())
    with RecordingReader(short) as recording:
        (begin_ns, end_ns), epoch_ns = recording.span_ns, recording.epoch_minus_clock_ns
    with short.open("rb") as file:
        reader = make_reader(file)
        tables = [table for table in reader.iter_metadata() if table.name != CLOCK_TABLE]
        documents = list(reader.iter_attachments())
        messages = list(_messages(reader, epoch_ns))

    def preamble(session: RecordingSession, now_ns: int) -> None:
        for table in tables:
            session.describe(table.name, table.metadata)
        for document in documents:
            session.attach(document.name, document.media_type, document.data, now_ns)

    session = RecordingSession(_plan(long), _date(begin_ns + epoch_ns), begin_ns, preamble)
    for later_ns in range(0, round(seconds * NS_PER_S), end_ns - steady_ns + BETWEEN_NS):
        for topic, data, t_ns, published_ns in messages:
            if later_ns == 0 or t_ns >= steady_ns:
                session.add(topic, data, t_ns + later_ns, published_ns + later_ns)
                session.tend(t_ns + later_ns)
    session.end()


def _messages(reader: McapReader, epoch_ns: int) -> Iterator[Kept]:
    topics = dict[int, Topic]()
    for schema, channel, message in reader.iter_messages():
        if channel.id not in topics:
            topics[channel.id] = _topic(schema, channel)
        yield Kept(topics[channel.id], message.data, message.log_time - epoch_ns, message.publish_time - epoch_ns)


def _topic(schema: Schema | None, channel: Channel) -> Topic:
    known = MessageSchema(schema.name, schema.encoding, schema.data) if schema is not None else MessageSchema("")
    return Topic(channel.topic, channel.message_encoding, known, dict(channel.metadata))


def _plan(file: Path) -> RecordingPlan:
    return RecordingPlan(file.parent, "bench", "bench", RecordConfig(), file)


def _date(since_1970_ns: int) -> datetime:
    return EPOCH + timedelta(microseconds=since_1970_ns // 1000)
