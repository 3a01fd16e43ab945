"""Transport over loopback: newest wins, requests happen once, endpoints beyond loopback are refused."""

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack

import msgspec
import pytest

import tests.common.messages.golden_examples as golden
from common.errors import MessageError, TransportError
from common.link.channels import CHANNELS, CLOCK, ENGAGEMENT, HAND, PREVIEW, ChannelSession
from common.link.config import ON_THIS_HOST
from common.link.endpoints import check_endpoint, stays_here
from common.link.pubsub import Latest, Publisher
from common.link.remote_clock import RemoteClock
from common.link.request_client import RequestClient
from common.link.transport import Link, open_link
from common.messages.codec import encode
from common.messages.hand import HandArm
from common.messages.requests import ClockAnswer, ClockQuestion, EngagementAction, EngagementRequest, Reply
from lab.stage.waiting import until

WAIT_S = 9.0


def free_endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@pytest.fixture
def links() -> Iterator[tuple[Link, Link]]:
    endpoint = free_endpoint()
    with open_link(listen=(endpoint,)) as server, open_link(connect=(endpoint,)) as client:
        yield server, client


def until_received(publisher: Publisher[HandArm], latest: Latest[HandArm], message: HandArm) -> HandArm:
    deadline = time.monotonic() + WAIT_S
    while time.monotonic() < deadline:
        publisher.put(message)
        time.sleep(0.01)
        received = latest.take()
        if received is not None:
            return received
    raise AssertionError("nothing came")


@pytest.mark.slow
def test_the_newest_message_wins(links: tuple[Link, Link]) -> None:
    server, client = links
    latest, publisher = server.latest(HAND, "lab"), client.publisher(HAND, "lab", operator="anna")
    until_received(publisher, latest, golden.HAND)
    for seq in range(100, 120):
        publisher.put(msgspec.structs.replace(golden.HAND, seq=seq))
    deadline = time.monotonic() + WAIT_S
    seqs: list[int] = []
    while time.monotonic() < deadline and seqs[-1:] != [119]:
        time.sleep(0.02)
        message = latest.take()
        if message is not None:
            seqs.append(message.seq)
    assert seqs[-1] == 119
    assert seqs == sorted(set(seqs))
    assert latest.take() is None


def test_a_random_payload_is_a_rejection(links: tuple[Link, Link]) -> None:
    server, client = links
    latest, publisher = server.latest(HAND, "lab"), client.publisher(HAND, "lab", operator="anna")
    until_received(publisher, latest, golden.HAND)
    publisher._publisher.put(b"\x93random")
    received: list[HandArm] = []  # samples still in transit come first
    with pytest.raises(MessageError, match="malformed"):
        received.extend(iter(latest.wait, None))


def serve(link: Link, handled: list[int], stop: threading.Event, delay_s: float = 0.0) -> threading.Thread:
    server = link.serve(ENGAGEMENT, "lab", print)

    def handle(request: EngagementRequest) -> Reply:
        handled.append(request.id)
        time.sleep(delay_s)
        return Reply(id=request.id, done=True, code="ok", reason="")

    def run() -> None:
        while not stop.is_set():
            server.poll(time.monotonic_ns(), handle)
            time.sleep(0.002)

    thread = threading.Thread(target=run)
    thread.start()
    return thread


def ask(link: Link, identity: int, seconds: float = WAIT_S) -> Reply:
    """The reply to an engagement under this id, however often it is asked for."""

    def make(*, id: int, deadline_ns: int) -> EngagementRequest:  # noqa: A002, ARG001  # the message's fields
        return EngagementRequest(id=identity, deadline_ns=deadline_ns, action=EngagementAction.ENGAGE)

    return RequestClient(link, "lab", operator="anna", patience_ns=round(seconds * 1e9)).ask(ENGAGEMENT, make)


@pytest.mark.slow
def test_a_request_repeated_with_its_id_happens_once(links: tuple[Link, Link]) -> None:
    server, client = links
    handled: list[int] = []
    stop = threading.Event()
    thread = serve(server, handled, stop, delay_s=0.7)
    try:
        first, again, other = ask(client, 1), ask(client, 1), ask(client, 2)
    finally:
        stop.set()
        thread.join()
    assert first == again
    assert other.id == 2
    assert handled == [1, 2]


@pytest.mark.slow
@pytest.mark.parametrize(("deadline_ns", "code"), [(0, b"expired"), (2**62, b"deadline")])
def test_an_expired_request_and_one_that_would_never_expire_are_refused(
    links: tuple[Link, Link], deadline_ns: int, code: bytes
) -> None:
    server, client = links
    stop = threading.Event()
    handled: list[int] = []
    thread = serve(server, handled, stop)
    try:
        ask(client, 1)
        time.sleep(0.02)  # requests that follow each other immediately are dropped
        late = EngagementRequest(id=9, deadline_ns=deadline_ns, action=EngagementAction.ENGAGE)
        replies = client._session.get(ENGAGEMENT.key_for("lab", operator="anna"), payload=encode(late), timeout=WAIT_S)
        payloads = [reply.ok.payload.to_bytes() for reply in replies if reply.ok]
    finally:
        stop.set()
        thread.join()
    assert handled == [1]
    assert payloads
    assert code in payloads[0]


def test_what_is_larger_than_its_channel_allows_never_arrives(links: tuple[Link, Link]) -> None:
    server, client = links
    latest, publisher = server.latest(HAND, "lab"), client.publisher(HAND, "lab", operator="anna")
    until_received(publisher, latest, golden.HAND)
    publisher._publisher.put(bytes(HAND.max_bytes + 1))
    publisher.put(msgspec.structs.replace(golden.HAND, seq=1000))
    taken: list[HandArm | None] = []
    until(lambda: taken.append(latest.take()) or (taken[-1] is not None and taken[-1].seq == 1000))
    publisher._publisher.put(bytes(HAND.max_bytes))
    with pytest.raises(MessageError, match="malformed"):
        latest.wait()


@pytest.mark.slow
def test_one_neighbours_flood_of_questions_leaves_room_for_anothers() -> None:
    endpoint, stop, answered = free_endpoint(), threading.Event(), [0]

    def answer(_question: ClockQuestion) -> ClockAnswer:
        answered[0] += 1
        return ClockAnswer(received_ns=1, answered_ns=1)

    def serve_clock(server: Link) -> None:
        clock = server.answer(CLOCK, "lab", print)
        while not stop.wait(0.004):
            clock.poll(answer)

    def flood(link: Link) -> None:
        while not stop.is_set():
            link._session.get(CLOCK.key_for("lab"), payload=encode(ClockQuestion()), timeout=0.3)
            time.sleep(0.0002)

    with ExitStack() as stack:
        server = stack.enter_context(open_link(listen=(endpoint,)))
        rude, polite = (stack.enter_context(open_link(connect=(endpoint,))) for _ in range(2))
        threads = [threading.Thread(target=serve_clock, args=(server,)), threading.Thread(target=flood, args=(rude,))]
        for thread in threads:
            thread.start()
        until(lambda: answered[0] > 20)
        heard = [RemoteClock(polite, "lab").measure() for _ in range(4) if not stop.wait(0.1)]
        stop.set()
        for thread in threads:
            thread.join()
    assert any(heard)


def test_a_publisher_knows_whether_anybody_listens() -> None:
    endpoint = free_endpoint()
    with open_link(listen=(endpoint,), send_buffer_bytes=1 << 18) as server:
        publisher = server.publisher(PREVIEW, "lab", "left", operator="anna")
        assert not publisher.has_listener
        with open_link(connect=(endpoint,)) as client:
            latest = client.latest(PREVIEW, "lab")
            until(lambda: publisher.has_listener)
            publisher.put(golden.VIDEO)
            until(lambda: latest.take() == golden.VIDEO)
        until(lambda: not publisher.has_listener)


@pytest.mark.slow
def test_nobody_answering_is_an_error() -> None:
    with open_link(connect=(free_endpoint(),)) as client, pytest.raises(TransportError, match="nobody answered"):
        ask(client, 1, seconds=0.4)


def test_a_taken_port_is_an_error_that_says_so() -> None:
    endpoint = free_endpoint()
    with open_link(listen=(endpoint,)), pytest.raises(TransportError, match="has this port; end it, or choose another"):
        open_link(listen=(endpoint,))


BEYOND_PORTS = ("tcp/127.0.0.1:0", "tcp/127.0.0.1:65536")


@pytest.mark.parametrize(
    "endpoint",
    ["tcp/0.0.0.0:7447", "tcp/192.168.1.4:7447", "udp/127.0.0.1:1", "tls/127.0.0.1:1", "x", "", *BEYOND_PORTS],
)
def test_endpoints_beyond_loopback_are_refused(endpoint: str) -> None:
    with pytest.raises(TransportError, match="refused"):
        check_endpoint(endpoint, ON_THIS_HOST)


def test_what_stays_on_this_host_is_known_by_its_endpoint() -> None:
    assert all(map(stays_here, ["tcp/127.0.0.1:7447", "tls/localhost:1", "quic/[::1]:7447"]))
    assert not any(map(stays_here, ["tls/0.0.0.0:7447", "tcp/192.168.1.4:7447", "quic/robot.example.org:7447", ""]))


@pytest.mark.parametrize("session", list(ChannelSession))
def test_a_link_refuses_what_belongs_to_the_other_session(session: ChannelSession) -> None:
    with open_link(listen=(free_endpoint(),), sessions=[session]) as link:
        for channel in CHANNELS:
            for declare in (link.publisher, link.latest):
                if channel.session is session:
                    declare(channel, "lab")
                    continue
                why = f"of the {session} session may not .*{channel.session} endpoint"
                with pytest.raises(TransportError, match=why):
                    declare(channel, "lab")
        if session is ChannelSession.VIDEO:
            with pytest.raises(TransportError, match=r"may not ask .*control endpoint"):
                link.ask(CLOCK, "lab", ClockQuestion())
            with pytest.raises(TransportError, match=r"may not answer .*control endpoint"):
                link.answer(CLOCK, "lab", print)


def test_a_link_of_both_sessions_carries_both() -> None:
    with open_link(listen=(free_endpoint(),), sessions=list(ChannelSession)) as link:
        for channel in CHANNELS:
            link.latest(channel, "lab")
