"""Viewers at an endpoint of their own: they see and ask through it, command nothing, and keep nobody out."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

import tests.common.messages.golden_examples as golden
from common.errors import ConfigError, RefusedError
from common.link.channels import CAMERA, CLOCK, DESCRIBE, ENGAGEMENT, HAND, KEY_FRAMES, STATE, ChannelSession
from common.link.config import TlsConfig, ViewersConfig
from common.link.credentials import check_viewers
from common.link.roles import Identity, Role
from common.link.transport import Link, open_link
from common.messages.requests import ClockQuestion, DescribeQuestion, EngagementAction
from common.messages.video import KeyFrameRequest
from farhand.certificates.authorities import load_authority
from farhand.certificates.issuing import issue
from lab.stage.waiting import until
from tests.common.link.secured_cell import (
    ANNA,
    CELL,
    HAND_SAMPLE,
    QUIET_S,
    Cell,
    commands_arrive,
    dishonest,
    free_port,
    keep,
    reply_to,
    request,
    running,
    secured,
)
from tests.common.link.watched_cell import watched

CROWD = 70  # more than a session has neighbours
BOTH = [ChannelSession.CONTROL, ChannelSession.VIDEO]


@dataclass
class Watched:
    """A cell with pictures, and where viewers watch it."""

    pki: Path
    cell: Cell
    video: Link
    endpoint: str

    def connect(self) -> Link:
        return open_link(connect=(self.endpoint,), security=secured(self.pki, "viewer"), sessions=BOTH)


@pytest.fixture(params=["tls", "quic"])
def site(pki: Path, request: pytest.FixtureRequest) -> Iterator[Watched]:
    pictures, security = f"tls/127.0.0.1:{free_port()}", secured(pki, "remote")
    with ExitStack() as stack:
        cell = stack.enter_context(running(security, request.param))
        only = [ChannelSession.VIDEO]
        video = stack.enter_context(open_link(listen=(pictures,), security=security, sessions=only))
        endpoint = stack.enter_context(watched(pki, (cell.endpoint, pictures)))
        yield Watched(pki, cell, video, endpoint)


@pytest.mark.parametrize("site", ["tls"], indirect=True)
def test_a_crowd_of_viewers_keeps_no_stop_out(site: Watched) -> None:
    with ExitStack() as stack:
        anna = secured(site.pki, "operator.anna")
        operator = stack.enter_context(open_link(connect=(site.cell.endpoint,), security=anna))
        until(lambda: operator.ask(CLOCK, CELL, ClockQuestion()))
        for _ in range(CROWD):
            stack.enter_context(dishonest(site.endpoint, site.pki, "viewer"))
        assert reply_to(operator, EngagementAction.STOP).done
        later = open_link(connect=(site.cell.endpoint,), security=secured(site.pki, "maintenance"))
        maintenance = stack.enter_context(later)
        assert reply_to(maintenance, EngagementAction.STOP, maintenance=True).done


def test_a_viewer_sees_state_pictures_and_description_and_asks_the_time(site: Watched) -> None:
    described, pictures = site.cell.link.answer(DESCRIBE, CELL, print), site.video.publisher(CAMERA, CELL, "side")

    def show() -> None:
        pictures.put(golden.VIDEO)
        described.poll(lambda _: golden.DESCRIPTION)

    with site.connect() as viewer, repeated(show):
        state, picture = viewer.latest(STATE, CELL), viewer.latest(CAMERA, CELL)
        until(state.take)
        until(lambda: picture.take() == golden.VIDEO)
        until(lambda: viewer.ask(CLOCK, CELL, ClockQuestion()))
        until(lambda: viewer.ask(DESCRIBE, CELL, DescribeQuestion()) == golden.DESCRIPTION)


@pytest.mark.slow
def test_pictures_are_sent_for_viewers_only_while_one_listens(site: Watched) -> None:
    pictures = site.video.publisher(CAMERA, CELL, "side")
    with site.connect() as viewer:
        listening = viewer.latest(CAMERA, CELL)
        until(lambda: pictures.has_listener)
        listening.close()
        until(lambda: not pictures.has_listener)


@pytest.mark.slow
def test_of_all_that_viewers_send_only_so_much_reaches_the_site(site: Watched) -> None:
    asked = site.video.latest(KEY_FRAMES, CELL)
    request = KeyFrameRequest(camera="side", after_seq=0)
    with site.connect() as viewer:
        viewer_asks = viewer.publisher(KEY_FRAMES, CELL)
        with repeated(lambda: viewer_asks.put(request), 0.002):
            until(asked.take)
            time.sleep(2.0)  # the burst is over
            while asked.take() is not None:
                pass
            heard, ends = 0, time.monotonic() + 2.0
            while time.monotonic() < ends:
                heard += asked.take() is not None
                time.sleep(0.005)
    assert 10 <= heard <= 25  # ten a second; 1000 were sent


def test_a_viewers_own_side_refuses_what_it_may_not(site: Watched) -> None:
    with site.connect() as link:
        with pytest.raises(RefusedError, match=r"viewer\.lab may not send .*/hand/anna: that takes one of operator"):
            link.publisher(HAND, CELL, operator=ANNA)
        with pytest.raises(RefusedError, match=r"may not ask .*engagement"):
            link.ask(ENGAGEMENT, CELL, request(), operator=ANNA)
        with pytest.raises(RefusedError, match=r"may not receive .*/hand"):
            link.latest(HAND, CELL, operator=ANNA)


@pytest.mark.slow
def test_a_viewer_commands_nothing_through_it_and_hears_no_hand(site: Watched) -> None:
    anna = secured(site.pki, "operator.anna")
    with (
        open_link(connect=(site.cell.endpoint,), security=anna) as operator,
        dishonest(site.endpoint, site.pki, "viewer") as viewer,
    ):
        heard: set[str] = set()
        for key in ("**", HAND.key_for(CELL, operator=ANNA)):
            viewer.declare_subscriber(key, lambda sample: heard.add(str(sample.key_expr)))
        hand, before = operator.publisher(HAND, CELL, operator=ANNA), site.cell.hands
        until(lambda: hand.put(HAND_SAMPLE) or site.cell.hands > before)
        time.sleep(QUIET_S)
        assert heard <= {STATE.key_for(CELL)}
        assert not commands_arrive(viewer, site.cell)


@pytest.mark.slow
def test_only_viewers_are_let_in_there(site: Watched) -> None:
    with pytest.raises(RefusedError, match="comes from another authority"):
        open_link(connect=(site.endpoint,), security=secured(site.pki, "operator.anna"))
    with dishonest(site.endpoint, site.pki, "viewers-remote") as session:
        heard = session.declare_subscriber(STATE.key_for(CELL))
        time.sleep(QUIET_S)
        assert heard.try_recv() is None


@pytest.mark.slow
def test_a_viewer_at_the_control_endpoint_is_told_where_viewers_connect(pki: Path, cell: Cell) -> None:
    with pytest.raises(RefusedError, match=r"viewers connect to links\.viewers there"):
        open_link(connect=(cell.endpoint,), security=secured(pki, "viewer"))


@pytest.mark.slow
def test_a_viewers_certificate_of_before_is_let_see_nothing_and_told_so(pki: Path, cell: Cell) -> None:
    old = Identity(Role.VIEWER, CELL)
    days = timedelta(days=9)
    keep(pki / CELL / "old", issue(load_authority(pki), old, ("127.0.0.1",), datetime.now(UTC), days))
    with open_link(connect=(cell.endpoint,), security=secured(pki, "old")) as link:
        state = link.latest(STATE, CELL)
        assert link.ask(CLOCK, CELL, ClockQuestion()) is None
        assert state.take() is None
        assert "viewers connect to links.viewers there" in link.why_silent()
    with dishonest(cell.endpoint, pki, "old") as session:
        assert not commands_arrive(session, cell)


def test_the_same_authority_for_viewers_and_sites_is_refused_with_the_reason(pki: Path) -> None:
    site, remote = secured(pki, "remote").tls, Identity(Role.REMOTE, CELL)
    listen = f"tls/127.0.0.1:{free_port()}"
    check_viewers(ViewersConfig(listen=listen, tls=secured(pki, "viewers-remote").tls), site, remote, "links.viewers")
    copied = TlsConfig(ca=f"{pki}/copy.pem", certificate=site.certificate, key=site.key)
    (pki / "copy.pem").write_bytes((pki / "ca.pem").read_bytes())
    with pytest.raises(ConfigError, match=r"links\.viewers\.ca: .*viewers could take all sessions .* viewers-ca\.pem"):
        check_viewers(ViewersConfig(listen=listen, tls=copied), site, remote, "links.viewers")


def test_viewers_connect_by_tls_alone_and_with_certificates(pki: Path) -> None:
    tls = secured(pki, "viewers-remote").tls
    for listen in ("tcp/127.0.0.1:7449", "quic/127.0.0.1:7449"):
        with pytest.raises(ValueError, match="by TLS alone"):
            ViewersConfig(listen=listen, tls=tls)
    for incomplete in ({"listen": "tls/127.0.0.1:7449"}, {"tls": tls}):
        with pytest.raises(ValueError, match="belong together"):
            ViewersConfig(**incomplete)


def test_a_passage_without_its_site_waits_for_it(pki: Path) -> None:
    port = free_port()
    with (
        watched(pki, (f"tls/0.0.0.0:{port}",)) as endpoint,
        open_link(connect=(endpoint,), security=secured(pki, "viewer")) as viewer,
    ):
        state = viewer.latest(STATE, CELL)
        assert state.take() is None
        with running(secured(pki, "remote"), "tls", port):
            until(state.take)


class repeated:  # noqa: N801  # reads as what it does
    """Does something every few milliseconds while the block runs."""

    def __init__(self, do: Callable[[], object], every_s: float = 0.02) -> None:
        self._do, self._every_s, self._ended = do, every_s, threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        while not self._ended.wait(self._every_s):
            self._do()

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
