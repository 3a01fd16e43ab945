"""Which topics a file of a recording takes: without a list of operators anybody on a host invents names without end."""

from pathlib import Path

import structlog

from common.recording.topics import MessageSchema, Topic

MOST_TOPICS_BYTES = 256 << 10  # of names and schemas; a site's own are some 50 kB, and a reader takes 1 MB
SHOWN_NAME = 80


class TakenTopics:
    """As many topics as MOST_TOPICS_BYTES describe, the first that come; the log says the first that is left out."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._names = set[str]()
        self._schemas = set[MessageSchema]()
        self._bytes = 0
        self._is_full = False

    def take(self, topic: Topic) -> bool:
        """Whether the file has this topic, or takes it now."""
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
