"""Requests of pages: only the operating page's are accepted, but any page may stop; the rest is refused."""

import asyncio
import threading
from collections.abc import Callable
from typing import Any

import msgspec
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import MessageError
from common.messages.hand import ClutchKey, OperatorSettings
from common.messages.recording import EpisodeOutcome
from common.messages.requests import EngagementAction, OperatorAction, PicturePoint, RecordAction, Reply
from common.messages.robot import Asker
from local_site.console.message_handler import Outlets, PageMessageHandler
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.page_messages import parse
from local_site.console.model.seat import Seat, Visitor
from local_site.console.page import Page
from local_site.console.request_pools import MOST_WAITING

LEASE = 41


class Told(Page):
    """Replaces a page, and a publisher: keeps what it is sent."""

    def __init__(self, number: int = 0) -> None:
        self.visitor = Visitor(number, "127.0.0.1")
        self.answers: list[dict[str, Any]] = []
        self.messages: list[Any] = []

    def send(self, **fields: Any) -> None:
        self.answers.append(fields)

    def put(self, message: object) -> None:
        self.messages.append(message)


class Sites:
    """Answer everything; engaging only once they are let, where nothing has withdrawn it by then."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.seen_ns: list[int] = []
        self.slow = threading.Event()
        self.stopping = threading.Event()
        self.stopping.set()
        self.on_stop: Callable[[], object] = list
        self.consented: Asker | None = None

    def engagement(self, action: EngagementAction, seen_ns: int = 0, withdrawn: threading.Event | None = None) -> Reply:
        if action is EngagementAction.STOP:
            self.on_stop()
            self.stopping.wait(5)
        else:
            self.slow.wait(5)
        if withdrawn is not None and withdrawn.is_set():
            return Reply(id=1, done=False, code="silent", reason="not sent any more")
        self.asked.append(action.value)
        self.seen_ns.append(seen_ns)
        return Reply(id=1, done=True, code="ok", reason="as asked")

    def lease(self, action: OperatorAction, to: Asker | None) -> Reply:
        self.asked.append(action.value)
        self.consented = to
        return Reply(id=1, done=False, code="nobody_asks", reason="nobody asks")

    def record(self, action: RecordAction, _outcome: EpisodeOutcome) -> Reply:
        self.asked.append(action.value)
        return Reply(id=1, done=True, code="ok", reason="as asked")

    def joints(self, *_points: PicturePoint) -> Reply:
        self.asked.append("joints")
        return Reply(id=1, done=True, code="ok", reason="as asked")


class Room:
    """A message handler with two pages, of which the first operates."""

    def __init__(self) -> None:
        self.sites, self.intent, self.shown = Sites(), Told(), Told()
        self.first, self.second = Told(1), Told(2)
        self.history = History()
        seat = Seat(open_=True)
        seat.arrive(self.first.visitor, NS_PER_S)
        self.handler = PageMessageHandler(
            seat, Outlets(self.intent.put, self.shown.put), self.sites, Latencies(), self.history, 9
        )
        self.adopt(OperatorSettings(lease=LEASE))

    def adopt(self, in_force: OperatorSettings | None, now_ns: int = NS_PER_S, lease: int = LEASE) -> None:
        self.handler.adopt(in_force, lease, "", now_ns)

    def say(self, page: Told, **said: object) -> None:
        self.handler.handle(page, parse(msgspec.json.encode(said).decode()), NS_PER_S)

    async def wait_for_answers(self, page: Told, count: int) -> list[dict[str, Any]]:
        for _ in range(500):
            if len(page.answers) >= count:
                break
            await asyncio.sleep(0.01)
        return page.answers


@pytest.fixture
def room():
    room = Room()
    yield room
    room.sites.slow.set()
    room.handler.close()


def test_a_watching_page_may_stop_and_nothing_else(room: Room) -> None:
    async def talk() -> None:
        room.say(room.second, type="ask", id=1, action="engage")
        room.say(room.second, type="ask_lease", id=2, action="give")
        room.say(room.second, type="new_origins")
        room.say(room.second, type="steer", scale=2.0)
        assert [answer["code"] for answer in room.second.answers] == ["watching"] * 2
        assert "page 1 (127.0.0.1) operates" in room.second.answers[0]["reason"]
        room.say(room.second, type="ask", id=3, action="stop")
        answer = (await room.wait_for_answers(room.second, 3))[-1]
        assert (answer["id"], answer["what"], answer["done"]) == (3, "stop", True)

    asyncio.run(talk())
    assert room.sites.asked == ["stop"]
    assert room.handler.settings == OperatorSettings(lease=LEASE)


def test_consent_goes_on_in_the_name_that_the_page_showed(room: Room) -> None:
    shown = {"name": "ben", "session": "4611686018427387903"}

    async def talk() -> None:
        room.say(room.first, type="ask_lease", id=1, action="give", to=shown)
        await room.wait_for_answers(room.first, 1)

    asyncio.run(talk())
    assert room.sites.consented == Asker("ben", 4611686018427387903)


def test_a_stop_never_waits_behind_other_requests(room: Room) -> None:
    async def talk() -> None:
        for number in range(MOST_WAITING):
            room.say(room.first, type="ask", id=number, action="engage")
        room.say(room.first, type="ask", id=99, action="stop")
        assert (await room.wait_for_answers(room.first, 1))[0]["id"] == 99
        room.sites.slow.set()
        assert len(await room.wait_for_answers(room.first, 1 + MOST_WAITING)) == 1 + MOST_WAITING

    asyncio.run(talk())


@pytest.mark.parametrize(("last", "by"), [("stop", "first"), ("stop", "second"), ("disengage", "first")])
def test_nothing_that_moves_the_arm_overtakes_a_later_stop_or_disengagement(room: Room, last: str, by: str) -> None:
    """Resets and engagements that nobody has answered yet are not sent again, nor are those that wait for a thread."""

    async def talk() -> None:
        for number, action in enumerate(("reset", "engage", "engage", "engage")):
            room.say(room.first, type="ask", id=number, action=action)
        room.say(getattr(room, by), type="ask", id=9, action=last)
        room.sites.slow.set()
        answers = await room.wait_for_answers(room.first, 5 if by == "first" else 4)
        assert [answer["done"] for answer in answers if answer["id"] != 9] == [False] * 4
        await room.wait_for_answers(getattr(room, by), 1)
        room.say(room.first, type="ask", id=10, action="engage")
        await room.wait_for_answers(room.first, len(room.first.answers) + 1)

    asyncio.run(talk())
    assert room.sites.asked == [last, "engage"]


def test_a_page_that_only_watches_withdraws_nothing_by_a_disengagement(room: Room) -> None:
    async def talk() -> None:
        room.say(room.first, type="ask", id=1, action="engage")
        room.say(room.second, type="ask", id=2, action="disengage")
        room.sites.slow.set()
        await room.wait_for_answers(room.first, 1)

    asyncio.run(talk())
    assert room.sites.asked == ["engage"]


def test_a_request_names_the_halt_that_the_page_showed(room: Room) -> None:
    room.sites.slow.set()
    shown = "9223372036854775807"  # JavaScript would round it

    async def talk() -> None:
        room.say(room.first, type="ask", id=1, action="reset", seen=shown)
        await room.wait_for_answers(room.first, 1)

    asyncio.run(talk())
    assert room.sites.seen_ns == [int(shown)]


def test_of_twenty_thousand_questions_of_one_page_a_few_wait_and_the_rest_is_refused_at_once(room: Room) -> None:
    async def talk() -> None:
        for number in range(20_000):
            room.say(room.first, type="ask", id=number, action="engage")
        await asyncio.sleep(0.05)
        assert len(room.first.answers) == 20_000 - MOST_WAITING
        assert {answer["code"] for answer in room.first.answers} == {"busy"}
        room.sites.slow.set()
        await room.wait_for_answers(room.first, 20_000)

    asyncio.run(talk())
    assert room.sites.asked == ["engage"] * MOST_WAITING


def test_a_flood_of_stops_makes_another_pages_stop_wait_for_one_at_most(room: Room) -> None:
    under_way, room.sites.stopping = threading.Event(), threading.Event()
    room.sites.on_stop = under_way.set

    async def talk() -> None:
        room.say(room.second, type="ask", id=0, action="stop")
        await asyncio.to_thread(under_way.wait, 5)
        for number in range(1, 20_000):
            room.say(room.second, type="ask", id=number, action="stop")
        room.say(room.first, type="ask", id=7, action="stop")
        room.sites.stopping.set()
        assert (await room.wait_for_answers(room.first, 1))[0]["done"]
        answered = await room.wait_for_answers(room.second, 1 + MOST_WAITING)
        assert [answer["id"] for answer in answered] == [0, *range(20_000 - MOST_WAITING, 20_000)]

    asyncio.run(talk())
    assert room.sites.asked == ["stop"] * 2


def test_a_stop_asked_for_while_another_is_under_way_is_asked_for_after_it(room: Room) -> None:
    """Between the two somebody may have reset the arm."""
    under_way, room.sites.stopping = threading.Event(), threading.Event()
    room.sites.on_stop = under_way.set

    async def talk() -> None:
        room.say(room.first, type="ask", id=1, action="stop")
        await asyncio.to_thread(under_way.wait, 5)
        room.say(room.second, type="ask", id=2, action="stop")
        room.sites.stopping.set()
        await room.wait_for_answers(room.second, 1)

    asyncio.run(talk())
    assert room.sites.asked == ["stop"] * 2


def test_the_operating_page_steers_by_what_it_names(room: Room) -> None:
    room.say(room.first, type="steer", scale=0.5)
    room.say(room.first, type="steer", locks={"roll": True})
    room.say(room.first, type="steer", rotation_scale=0.25, locks={"z": True})
    room.say(room.first, type="new_origins")
    room.handler.send_intent(NS_PER_S)
    intent = room.intent.messages[-1].intent
    settings = intent.settings
    assert (settings.scale, settings.rotation_scale, settings.revision) == (0.5, 0.25, 4)
    assert (settings.locks.roll, settings.locks.z, settings.locks.x) == (True, True, False)
    assert not intent.hold


def test_a_beat_counts_from_the_consoles_time_that_its_page_had_heard(room: Room) -> None:
    for heard_ms, down in ((900, False), (900, True)):
        room.say(room.first, type="beat", page_ms=5.0, heard_ms=heard_ms, down=down)
    assert room.handler.seat.held(NS_PER_S + 200 * NS_PER_MS)
    room.say(room.first, type="beat", page_ms=5.0, heard_ms=500, down=True)
    assert not room.handler.seat.held(NS_PER_S)


@pytest.mark.parametrize(
    "said",
    [
        "",
        "null",
        "[]",
        '{"type": "dance"}',
        '{"type": "beat", "page_ms": "now", "heard_ms": null, "down": true}',
        '{"type": "beat", "page_ms": 1, "heard_ms": 1, "down": 1}',
        '{"type": "beat", "page_ms": 1, "heard_ms": 1, "down": true, "more": 1}',
        '{"type": "beat", "page_ms": 1, "down": true}',
        '{"type": "beat", "page_ms": 1, "heard_ms": -1, "down": true}',
        '{"type": "ask", "id": 1, "action": "move"}',
        '{"type": "ask", "id": -1, "action": "stop"}',
        '{"type": "ask", "id": 1, "action": "reset", "seen": 7}',
        '{"type": "ask", "id": 1, "action": "reset", "seen": "-7"}',
        '{"type": "ask_lease", "id": 1, "action": "give", "to": {"name": "ben", "session": 7}}',
        '{"type": "ask_lease", "id": 1, "action": "give", "to": {"name": "ben", "session": "-7"}}',
        '{"type": "steer", "scale": 50}',
        '{"type": "steer", "scale": NaN}',
        '{"type": "steer", "locks": {"w": true}}',
        '{"type": "shown", "h264": true, "views": {"camera/side": {"seq": 1, "age_ms": -5, "fps": 1}}}',
        '{"type": "shown", "views": {}}',
        '{"type": "lost"}',
    ],
)
def test_what_no_page_says_is_refused(said: str) -> None:
    with pytest.raises(MessageError):
        parse(said)


def test_the_clutch_goes_with_every_intent_as_the_operating_page_reports_it(room: Room) -> None:
    def told(page: Told, clutch: str) -> ClutchKey:
        room.say(page, type="beat", page_ms=5.0, heard_ms=950, down=False, clutch=clutch)
        room.handler.send_intent(NS_PER_S)
        key: ClutchKey = room.intent.messages[-1].intent.clutch
        return key

    assert told(room.first, "down") is ClutchKey.DOWN
    assert told(room.second, "up") is ClutchKey.DOWN
    assert told(room.first, "unseen") is ClutchKey.UNSEEN
    assert told(room.first, "up") is ClutchKey.UNSEEN
    assert told(room.first, "down") is ClutchKey.DOWN
    assert told(room.first, "up") is ClutchKey.UP
