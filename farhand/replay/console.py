"""A recording on the operator's page: served on this host, played at the recording's pace, and never taken for live."""

import asyncio
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import msgspec
import structlog
import uvicorn

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate, ClockOffset
from common.errors import RecordingError
from common.host_clock import MonotonicClock
from common.messages.hand import HandArm, OperatorSettings
from common.messages.requests import Reply
from common.messages.robot import RobotState
from common.messages.video import KeyFrameRequest, VideoFrame
from common.process.log import LogFormat, start_log
from common.process.service import StopFlag
from farhand.replay.playback import Playback
from farhand.replay.recorded_scene import RecordedScene, Shown
from local_site.console.config import ServeConfig
from local_site.console.hub import Hub
from local_site.console.key_frames import KeyFrames
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.page_messages import AnyPageMessage, Ask, Beat, FrameLost, FrameTaken, Play
from local_site.console.model.seat import Seat
from local_site.console.page import Page
from local_site.console.request_pools import answer
from local_site.console.server import bind, make_server

FEED_S, SITUATION_S = 0.01, 0.06
MOST_AT_ONCE = 2000  # messages between two turns of the event loop
NO_ROBOT = (
    "this is a replay, no robot is connected to it: for a real one use its own page, or the emergency stop at the robot"
)


def run_replay(
    scene: RecordedScene, name: str, serve: ServeConfig, should_stop: StopFlag, announce: Callable[[str], object]
) -> None:
    """Serve the page of a recording called `name` until asked to stop; `announce` gets its address."""
    start_log("replay", LogFormat.TEXT)
    asyncio.run(serve_replay(scene, name, serve, should_stop, announce))


async def serve_replay(
    scene: RecordedScene, name: str, serve: ServeConfig, should_stop: StopFlag, announce: Callable[[str], object]
) -> None:
    """As `run_replay`, without a log."""
    playback = Playback(MonotonicClock(), scene.begin_ns, scene.end_ns)
    player = RecordingPlayer(scene, name, playback)
    with bind(serve, "--port") as listening:
        port = listening.getsockname()[1]
        server = make_server(player.hub, serve, port)
        feeding = asyncio.create_task(_feed(player, server, should_stop))
        announce(f"replay of {name}: {serve.scheme}://{serve.host}:{port}/")
        await server.serve(sockets=[listening])
        feeding.cancel()


async def _feed(player: "RecordingPlayer", server: uvicorn.Server, should_stop: StopFlag) -> None:
    told_s = 0.0
    while not should_stop():
        player.feed()
        if time.monotonic() - told_s > SITUATION_S:
            told_s = time.monotonic()
            player.tell()
        await asyncio.sleep(FEED_S)
    server.should_exit = True


class RecordingPlayer:
    """Passes what was recorded to the hub when its time comes, and does what the page asks of the replay."""

    def __init__(self, scene: RecordedScene, name: str, playback: Playback) -> None:
        self._scene, self._playback = scene, playback
        self.seat = Seat(open_=False)
        self.settings: OperatorSettings | None = None
        self.hub = Hub(
            self,
            _OneClock(),
            Latencies(),
            History(),
            self._watch,
            KeyFrames(_asked_nobody),
            operator="",
            operate=False,
            clock=playback,
            replay=_described(scene, name),
        )
        self.hub.described(scene.cell)
        self._pictures: dict[str, VideoFrame] = {}
        self._is_begun, self._is_new, self._trouble = False, False, ""
        playback.play(playing=False)
        self._waiting = self._from(playback.begin_ns)
        self._next: tuple[int, Shown] | None = None
        self._advance()

    def feed(self) -> None:
        """Pass on what is due; of pictures that are due at once only each camera's newest."""
        now_ns, due = self._playback.now_ns(), set[str]()
        for _ in range(MOST_AT_ONCE):
            if self._next is None or self._next[0] > now_ns:
                break
            message = self._next[1]
            if isinstance(message, VideoFrame):
                self._pictures[message.camera] = message
                due.add(message.camera)
            elif isinstance(message, RobotState):
                self.hub.state(message)
            elif isinstance(message, HandArm):
                self.hub.hand(message)
            self._advance()
        for camera in self._pictures if self._is_new else due:
            self.hub.camera(self._pictures[camera])
        self._is_new = False

    def _advance(self) -> None:
        """Take the next message; where the recording is damaged the replay stands, and says so."""
        try:
            self._next = next(self._waiting, None)
        except RecordingError as error:
            self._next, self._trouble = None, str(error)
            self._playback.play(playing=False)
            structlog.get_logger().error("the replay stands", reason=self._trouble)

    def _watch(self, watched: bool) -> None:
        """A page has come, and gets the pictures that are shown; the first one starts the replay."""
        if watched and not self._is_begun:
            self._is_begun = True
            self._playback.play(playing=True)
        self._is_new = watched

    def tell(self) -> None:
        """Send the situation, and where the replay stands, to every page."""
        playback, now_ns = self._playback, self._playback.now_ns()
        self.hub.send_situation()
        stands = {
            "type": "replay",
            "running": playback.is_running,
            "speed": playback.speed,
            "position_s": (now_ns - playback.begin_ns) / NS_PER_S,
            "now_ms": now_ns / NS_PER_MS,
            "jumps": playback.jumps,
            "trouble": self._trouble,
        }
        self.hub.tell("replay", msgspec.json.encode(stands).decode())

    def adopt(self, in_force: OperatorSettings | None, lease: int, late: str, now_ns: int) -> None:
        """Show the scales and locks that were in force."""
        del lease, late, now_ns
        self.settings = in_force

    def remember(self, view: str, frame: VideoFrame, now_ns: int, clock: ClockOffset | None, *, usable: bool) -> None:
        """Nobody asks what was painted."""

    def handle(self, page: Page, message: AnyPageMessage, now_ns: int) -> None:
        """Play as asked; a page that asks for the robot is told that there is none."""
        match message:
            case Beat():
                page.send(type="echo", page_ms=message.page_ms, server_ms=now_ns / NS_PER_MS)
            case FrameTaken():
                page.taken(message.view)
            case FrameLost():
                page.slots.interrupt(message.view)
            case Play():
                self._play(message)
            case Ask():
                reply = Reply(id=message.id, done=False, code="replay", reason=NO_ROBOT)
                answer(page, message.id, message.action.value, reply)
            case _:
                pass  # controls that a watching page does not offer

    def _play(self, message: Play) -> None:
        playback = self._playback
        jumps = playback.jumps
        if message.speed is not None:
            playback.accelerate(message.speed)
        if message.position_s is not None:
            playback.jump(playback.begin_ns + round(message.position_s * NS_PER_S))
        if message.playing is not None:
            playback.play(playing=message.playing)
        if playback.jumps != jumps:
            self._jumped()

    def _jumped(self) -> None:
        self.hub.begin_again(Latencies(), History())
        self._trouble = ""
        self._waiting = self._from(self._playback.now_ns())
        self._advance()

    def _from(self, t_ns: int) -> Iterator[tuple[int, Shown]]:
        return self._scene.shown(t_ns)


class _OneClock:
    """The recording's times are all by one clock."""

    round_trip_ms: float | None = None

    def estimate(self, now_ns: int) -> ClockEstimate | None:
        """No offset."""
        return ClockEstimate(ClockOffset(0, 0), now_ns)


def _asked_nobody(request: KeyFrameRequest) -> None:
    """Every recorded picture stands for itself."""


def _described(scene: RecordedScene, name: str) -> dict[str, Any]:
    return {
        "name": name,
        "began": datetime.fromtimestamp(scene.began_ns / NS_PER_S, UTC).strftime("%Y-%m-%d %H:%M:%S UTC"),
        "duration_s": (scene.end_ns - scene.begin_ns) / NS_PER_S,
        "events": [asdict(event) for event in scene.events],
    }
