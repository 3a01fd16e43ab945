"""Commands for the processes that stand in for people and hardware: small JSON datagrams on a Unix socket."""

import json
import socket
from pathlib import Path
from typing import Any

LONGEST = 4096


class CommandSocket:
    """The socket on which a process receives its commands; receiving never waits."""

    def __init__(self, path: str) -> None:
        Path(path).unlink(missing_ok=True)
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(path)
        self._socket.setblocking(False)

    def fileno(self) -> int:
        """The descriptor, for `select`."""
        return self._socket.fileno()

    def take(self) -> dict[str, Any]:
        """The next command's fields; empty when there is none."""
        try:
            fields: dict[str, Any] = json.loads(self._socket.recv(LONGEST))
        except BlockingIOError:
            return {}
        return fields


def send(path: Path, **fields: Any) -> None:
    """Send a command to the socket at a path."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.sendto(json.dumps(fields).encode(), str(path))
