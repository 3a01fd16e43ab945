"""A page without a browser, its key up or down as commanded: `python -m tests.faults.page_client PORT SOCKET`.

It paints nothing, but acknowledges every picture and reports how old the newest are, as a page does.
"""

import itertools
import sys
import threading
import time

import msgspec
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from tests.faults.command_socket import CommandSocket

BEAT_S = 0.05
BEATS_PER_WORD = 2
FPS = 30.0  # a page that paints all that comes
ATTEMPTS, AGAIN_S = 300, 0.2


def run(port: int, commands: CommandSocket) -> None:
    """Beat until killed."""
    with opened(port) as page:
        views: dict[str, dict[str, float]] = {}
        threading.Thread(target=_read, args=(page, views), daemon=True).start()
        down = False
        for beat in itertools.count():
            down = commands.take().get("down", down)
            _say(page, type="beat", page_ms=time.monotonic() * 1e3, down=down)
            if beat % BEATS_PER_WORD == 0:
                _say(page, type="shown", views=dict(views))
            time.sleep(BEAT_S)


def opened(port: int) -> ClientConnection:
    """The page's connection, as soon as the console is there."""
    for _ in range(ATTEMPTS):
        try:
            return connect(f"ws://127.0.0.1:{port}/page", origin=Origin(f"http://127.0.0.1:{port}"))
        except ConnectionRefusedError:
            time.sleep(AGAIN_S)
    raise ConnectionRefusedError(f"no console at {port}")


def _read(page: ClientConnection, views: dict[str, dict[str, float]]) -> None:
    """Take every picture immediately; this host's clock is the console's."""
    for message in page:
        if isinstance(message, bytes):
            header = msgspec.json.decode(message[2 : 2 + int.from_bytes(message[:2], "little")])
            name, exposed_ms = header["view"], header["capture_ms"]
            _say(page, type="taken", view=name)
            if name.startswith("camera/") and exposed_ms is not None:
                age_ms = max(0.0, time.monotonic() * 1e3 - exposed_ms)
                views[name] = {"seq": header["seq"], "age_ms": age_ms, "fps": FPS}


def _say(page: ClientConnection, **fields: object) -> None:
    page.send(msgspec.json.encode(fields).decode())


if __name__ == "__main__":
    run(int(sys.argv[1]), CommandSocket(sys.argv[2]))
