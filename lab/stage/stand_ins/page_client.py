"""A page without a browser: `python -m lab.stage.stand_ins.page_client PORT SOCKET`.

Its key, clutch and settings are as commanded, and its beats are sent late by what it is told (`late_s`). It paints
nothing, but acknowledges every picture and reports how old the newest are, as a page does. `--sight FILE` keeps there
what it has seen of the cell; with `--down` its key is down from its first beat.
"""

import itertools
import threading
import time
from argparse import ArgumentParser
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import msgspec
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from common.clock import NS_PER_MS
from lab.stage.network.command_socket import CommandSocket
from lab.stage.stand_ins.pictures import SeenPictures, SightLog

BEAT_S = 0.05
BEATS_PER_WORD = 2
FPS = 30.0  # a page that paints all that comes
ATTEMPTS, AGAIN_S = 300, 0.2
CAMERA_VIEW = "camera/"


@dataclass
class HeardTime:
    """The console's time in its newest echo, None before the first."""

    console_ms: float | None = None


def run(port: int, commands: CommandSocket, seen: SightLog | None, *, down: bool) -> None:
    """Beat until killed."""
    with opened(port) as page:
        views: dict[str, dict[str, float]] = {}
        heard = HeardTime()
        threading.Thread(target=_read, args=(page, views, heard, seen), daemon=True).start()
        late_s, clutch, on_their_way = 0.0, "up", deque[tuple[float, dict[str, object]]]()
        for count in itertools.count():
            fields, now_s = commands.take(), time.monotonic()
            down, late_s = fields.get("down", down), fields.get("late_s", late_s)
            clutch = fields.get("clutch", clutch)
            if "steer" in fields:
                _say(page, type="steer", **fields["steer"])
            beat = {"page_ms": now_s * 1e3, "heard_ms": heard.console_ms, "down": down, "clutch": clutch}
            on_their_way.append((now_s + late_s, beat))
            while on_their_way and on_their_way[0][0] <= now_s:
                _say(page, type="beat", **on_their_way.popleft()[1])
            if count % BEATS_PER_WORD == 0:
                _say(page, type="shown", h264=True, views=dict(views))
            time.sleep(BEAT_S)


def opened(port: int) -> ClientConnection:
    """The page's connection, as soon as the console is there."""
    for _ in range(ATTEMPTS):
        try:
            return connect(f"ws://127.0.0.1:{port}/page", origin=Origin(f"http://127.0.0.1:{port}"))
        except ConnectionRefusedError:
            time.sleep(AGAIN_S)
    raise ConnectionRefusedError(f"no console at {port}")


def _read(page: ClientConnection, views: dict[str, dict[str, float]], heard: HeardTime, seen: SightLog | None) -> None:
    """Take every picture immediately; this host's clock is the console's."""
    for message in page:
        if isinstance(message, str):
            heard.console_ms = msgspec.json.decode(message).get("server_ms", heard.console_ms)
        else:
            now_ns = time.monotonic_ns()
            length = int.from_bytes(message[:2], "little")
            header = msgspec.json.decode(message[2 : 2 + length])
            name, exposed_ms = header["view"], header["capture_ms"]
            _say(page, type="taken", view=name)
            if not name.startswith(CAMERA_VIEW):
                continue
            age_ms = None if exposed_ms is None else max(0.0, now_ns / NS_PER_MS - exposed_ms)
            if age_ms is not None:
                views[name] = {"seq": header["seq"], "age_ms": age_ms, "fps": FPS}
            if seen is not None and len(message) > 2 + length:
                oldest_ms = None if age_ms is None else age_ms + header["unsure_ms"]
                seen.add(SeenPictures(name.removeprefix(CAMERA_VIEW), header["seq"], now_ns, oldest_ms))


def _say(page: ClientConnection, **fields: object) -> None:
    page.send(msgspec.json.encode(fields).decode())


if __name__ == "__main__":
    arguments = ArgumentParser()
    arguments.add_argument("port", type=int)
    arguments.add_argument("socket")
    arguments.add_argument("--sight", type=Path)
    arguments.add_argument("--down", action="store_true")
    given = arguments.parse_args()
    log = SightLog(given.sight) if given.sight is not None else None
    run(given.port, CommandSocket(given.socket), log, down=given.down)
