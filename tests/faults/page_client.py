"""An operator's page without a browser, its key up or down as told: `python page_client.py PORT EAR`."""

import sys
import threading
import time

import msgspec
from puppets import Ear
from websockets.sync.client import ClientConnection, connect

BEAT_S = 0.05
ATTEMPTS, AGAIN_S = 300, 0.2


def run(port: int, ear: Ear) -> None:
    """Beat until killed."""
    with opened(port) as page:
        threading.Thread(target=_read, args=(page,), daemon=True).start()
        down = False
        while True:
            down = ear.take().get("down", down)
            page.send(msgspec.json.encode({"type": "beat", "page_ms": time.monotonic() * 1e3, "down": down}).decode())
            time.sleep(BEAT_S)


def opened(port: int) -> ClientConnection:
    """The page's connection, as soon as the console is there."""
    for _ in range(ATTEMPTS):
        try:
            return connect(f"ws://127.0.0.1:{port}/page", origin=f"http://127.0.0.1:{port}")
        except ConnectionRefusedError:
            time.sleep(AGAIN_S)
    raise ConnectionRefusedError(f"no console at {port}")


def _read(page: ClientConnection) -> None:
    for _ in page:
        continue


if __name__ == "__main__":
    run(int(sys.argv[1]), Ear(sys.argv[2]))
