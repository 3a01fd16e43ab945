"""systemd as a daemon meets it: the socket that it notifies, and every word as it comes."""

import socket
import threading
from pathlib import Path


class Systemd:
    """Listens in a thread until it is closed; a daemon would wait for one that does not."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.words: list[str] = []
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while word := self._socket.recv(256).decode():
            self.words.append(word)

    def close(self) -> None:
        self._socket.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._socket.close()
