"""Words for what stands in for people and hardware: small JSON datagrams on a socket in the file system."""

import json
import socket
from pathlib import Path
from typing import Any

LONGEST = 4096


class Ear:
    """Where a process hears what it shall do; asking never waits."""

    def __init__(self, path: str) -> None:
        Path(path).unlink(missing_ok=True)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(path)
        self._socket.setblocking(False)

    def fileno(self) -> int:
        return self._socket.fileno()

    def take(self) -> dict[str, Any]:
        """The next words; empty when there are none."""
        try:
            words: dict[str, Any] = json.loads(self._socket.recv(LONGEST))
        except BlockingIOError:
            return {}
        return words


def tell(path: Path, **words: Any) -> None:
    """Say something to the ear at a path."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as mouth:
        mouth.sendto(json.dumps(words).encode(), str(path))
