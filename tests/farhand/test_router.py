"""The meeting point: sites that only connect reach each other, by their roles, and again after it was restarted."""

import json
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack
from datetime import UTC, datetime
from pathlib import Path

import pytest
import zenoh
from msgspec.structs import asdict

from common.config.loading import load_config
from common.errors import ConfigError, RefusedError, TransportError
from common.link.channels import CLOCK, HAND, STATE
from common.link.config import ViewersConfig
from common.link.endpoints import SECURED
from common.link.transport import Link, open_link, open_router
from common.messages.requests import ClockQuestion, EngagementAction
from farhand.certificates.folder import CertificateOrder, add_router, create
from farhand.loopback.site_process import start_site
from farhand.router import RouterConfig, zenohd_configuration
from lab.stage.waiting import until
from tests.common.link.secured_cell import (
    ANNA,
    CELL,
    OPERATORS,
    QUIET_S,
    ROBOT_STATE,
    Cell,
    another_sample,
    commands_arrive,
    dishonest,
    free_port,
    reply_to,
    secured,
)
from tests.common.link.watched_cell import watched
from tests.integration.sites import child_of

PROJECT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def pki(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pki")
    for name in (CELL, "other"):
        create(folder, CertificateOrder(name, (), 30, OPERATORS), datetime.now(UTC))
        add_router(folder, CertificateOrder(name, (), 30), datetime.now(UTC))
    return folder


class Meeting:
    """A router, and a cell that only connects to it."""

    def __init__(self, pki: Path, stack: ExitStack, protocol: str) -> None:
        self.pki, self.endpoint = pki, f"{protocol}/127.0.0.1:{free_port()}"
        self.router = self.open()
        site = open_link(
            connect=(self.endpoint,), security=secured(pki, "remote"), operators=OPERATORS, through_router=True
        )
        self.cell = Cell(self.endpoint, stack.enter_context(site))
        stack.callback(self.close)

    def close(self) -> None:
        self.cell.close()
        self.router.close()

    def open(self) -> Link:
        return open_router(listen=(self.endpoint,), security=secured(self.pki, "router"), operators=OPERATORS)

    def connect(self, who: str, cell: str = CELL) -> Link:
        return open_link(connect=(self.endpoint,), security=secured(self.pki, who, cell))


@pytest.fixture(params=SECURED)
def meeting(pki: Path, request: pytest.FixtureRequest) -> Iterator[Meeting]:
    with ExitStack() as stack:
        yield Meeting(pki, stack, request.param)


@pytest.mark.slow
@pytest.mark.parametrize("meeting", ["tls"], indirect=True)  # with QUIC a port is free when its process has ended
def test_sites_meet_and_meet_again_after_the_router_was_restarted(meeting: Meeting) -> None:
    with meeting.connect("operator.anna") as operator:
        hand, state = operator.publisher(HAND, CELL, operator=ANNA), operator.latest(STATE, CELL)
        for _ in range(2):
            before = meeting.cell.hands
            until(state.take)
            until(lambda: hand.put(another_sample()) or meeting.cell.hands > before)  # noqa: B023  # called here alone
            assert reply_to(operator, EngagementAction.ENGAGE).done
            meeting.router.close()
            while state.take() is not None:
                pass
            meeting.router = meeting.open()


@pytest.mark.slow
def test_a_site_waits_for_its_router_and_hears_when_that_refuses_it(pki: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    later: list[Link] = []

    def begin() -> None:
        time.sleep(0.7)
        security = secured(pki, "router")
        later.append(open_router(listen=(endpoint,), security=security, operators=OPERATORS))

    thread = threading.Thread(target=begin)
    thread.start()
    with open_link(connect=(endpoint,), security=secured(pki, "remote"), through_router=True) as site:
        assert len(site._session.info.links()) == 1
    thread.join()
    with later[0], pytest.raises(RefusedError, match="speaks TLS only"):
        open_link(connect=(endpoint.replace("tls/", "tcp/"),), through_router=True)


def test_who_is_asked_to_end_waits_for_no_router(pki: Path) -> None:
    endpoint, began = f"tls/127.0.0.1:{free_port()}", time.monotonic()
    with pytest.raises(TransportError, match="no router answers"):
        open_link(
            connect=(endpoint,),
            security=secured(pki, "remote"),
            through_router=True,
            should_stop=lambda: time.monotonic() > began + 0.3,
        )
    assert time.monotonic() - began < 10.0  # of 20


@pytest.mark.slow
def test_a_router_passes_on_nothing_that_a_role_may_not_send(meeting: Meeting) -> None:
    with (
        watched(meeting.pki, (meeting.endpoint,), "router") as endpoint,
        dishonest(endpoint, meeting.pki, "viewer") as session,
    ):
        assert not commands_arrive(session, meeting.cell)
    with dishonest(meeting.endpoint, meeting.pki, "operator.anna", cell="other") as session:
        assert not commands_arrive(session, meeting.cell)
    with dishonest(meeting.endpoint, meeting.pki, "operator.anna") as session:
        until(lambda: commands_arrive(session, meeting.cell))


@pytest.mark.slow
def test_a_router_of_another_cell_is_nobodys_meeting_point(pki: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    with open_router(listen=(endpoint,), security=secured(pki, "router", "other"), operators=OPERATORS):
        for who in ("remote", "operator.anna", "maintenance"):
            with pytest.raises(
                RefusedError, match=r"is not the remote site of cell lab: .* certificate of router\.other"
            ):
                open_link(connect=(endpoint,), security=secured(pki, who), through_router=who == "remote")


@pytest.mark.slow
def test_viewers_watch_at_the_router_and_hear_no_hand(meeting: Meeting) -> None:
    with ExitStack() as stack:
        operator = stack.enter_context(meeting.connect("operator.anna"))
        endpoint = stack.enter_context(watched(meeting.pki, (meeting.endpoint,), "router"))
        security = secured(meeting.pki, "viewer")
        viewer = stack.enter_context(open_link(connect=(endpoint,), security=security))
        until(viewer.latest(STATE, CELL).take)
        until(lambda: viewer.ask(CLOCK, CELL, ClockQuestion()))
        curious = stack.enter_context(dishonest(endpoint, meeting.pki, "viewer"))
        heard: set[str] = set()
        for key in ("**", HAND.key_for(CELL, operator=ANNA)):
            curious.declare_subscriber(key, lambda sample: heard.add(str(sample.key_expr)))
        hand, before = operator.publisher(HAND, CELL, operator=ANNA), meeting.cell.hands
        until(lambda: hand.put(another_sample()) or meeting.cell.hands > before + 10)
        time.sleep(QUIET_S)
        assert heard <= {STATE.key_for(CELL)}


@pytest.mark.slow
def test_whoever_else_has_the_routers_certificate_may_do_no_more_than_a_viewer(meeting: Meeting) -> None:
    with dishonest(meeting.endpoint, meeting.pki, "router") as session:
        assert not commands_arrive(session, meeting.cell)


@pytest.mark.slow
def test_the_routers_process_lets_viewers_watch_and_goes_on_without_the_one_that_serves_them(
    pki: Path, tmp_path: Path
) -> None:
    endpoint, seen_at = (f"tls/127.0.0.1:{free_port()}" for _ in range(2))
    settings = {"cell": CELL, "listen": json.dumps([endpoint]), "operators": json.dumps(OPERATORS)}
    settings |= {f"tls.{key}": path for key, path in asdict(secured(pki, "router").tls).items()}
    settings |= {f"viewers.tls.{key}": path for key, path in asdict(secured(pki, "viewers-router").tls).items()}
    arguments = [f"--set={key}={value}" for key, value in (settings | {"viewers.listen": seen_at}).items()]
    router = start_site("router", arguments, tmp_path)
    with ExitStack() as stack:
        stack.callback(router.end)
        site = open_link(connect=(endpoint,), security=secured(pki, "remote"), through_router=True)
        states = stack.enter_context(site).publisher(STATE, CELL)
        viewer = stack.enter_context(open_link(connect=(seen_at,), security=secured(pki, "viewer")))
        operator = stack.enter_context(open_link(connect=(endpoint,), security=secured(pki, "operator.anna")))
        seen, heard = viewer.latest(STATE, CELL), operator.latest(STATE, CELL)
        until(lambda: states.put(ROBOT_STATE) or seen.take())
        os.kill(child_of(router, "farhand-viewers"), signal.SIGKILL)
        until(lambda: any("process=viewers" in line for line in router.events))
        while heard.take() is not None:
            pass
        until(lambda: states.put(ROBOT_STATE) or heard.take())
        assert router.exit_code is None


def test_zenohd_serves_no_viewers(pki: Path) -> None:
    viewers = ViewersConfig(listen="tls/127.0.0.1:7449", tls=secured(pki, "viewers-router").tls)
    with pytest.raises(ConfigError, match=r"zenohd serves none; run 'farhand router'"):
        zenohd_configuration(RouterConfig(cell=CELL, viewers=viewers))


def test_zenohds_configuration_is_the_routers_and_can_be_read() -> None:
    deployed = PROJECT / "deploy/router/zenohd.json5"
    config = load_config(RouterConfig, PROJECT / "farhand/deployment/sites/router.toml")
    written = "".join(line for line in deployed.read_text().splitlines(True) if not line.startswith("//"))
    assert json.loads(written) == json.loads(zenohd_configuration(config))
    read = zenoh.Config.from_file(str(deployed))
    assert json.loads(read.get_json("mode")) == "router"
    assert json.loads(read.get_json("transport/link/tls"))["enable_mtls"] is True
    control = json.loads(read.get_json("access_control"))
    assert control["default_permission"] == "deny"
    assert {subject["cert_common_names"][0] for subject in control["subjects"]} == {
        "remote.cell",
        "operator.cell.anna",
        "maintenance.cell",
        "router.cell",
    }
