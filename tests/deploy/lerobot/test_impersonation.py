"""No action from somebody who is not the cell: whoever listens shows the certificate of its remote site or router."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

import msgspec
import pytest
import zenoh
from lerobot_teleoperator_farhand import FarhandTeleop, FarhandTeleopConfig
from lerobot_teleoperator_farhand.feed import StaleDataError

import tests.common.messages.golden_examples as golden
from common.link.channels import CLOCK, DESCRIBE, STATE
from common.link.roles import Role
from common.messages.codec import encode
from common.messages.requests import ClockAnswer
from farhand.certificates import issuing
from farhand.certificates.folder import CertificateOrder, create
from tests.common.link.secured_cell import dishonest, free_port
from tests.deploy.lerobot.conftest import CELL, CELL_STATE
from tests.deploy.lerobot.test_live_actions import action

JOINTS = [joint.name for joint in golden.DESCRIPTION.joints]
BACK_S = 2.0  # more than Zenoh waits between two tries


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return made(tmp_path)


@pytest.fixture
def earlier(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Certificates as releases before 0.3 made them: each is for a server too."""
    monkeypatch.setattr(issuing, "LISTENERS", frozenset(Role))
    return made(tmp_path)


def made(folder: Path) -> Path:
    create(folder, CertificateOrder(CELL, (), 30, ("anna",)), datetime.now(UTC))
    return folder


@contextmanager
def impersonated(folder: Path, who: str, port: int | None = None) -> Iterator[str]:
    """The endpoint of somebody who answers as the cell would, with the certificate `who`."""
    endpoint, ended = f"tls/127.0.0.1:{port or free_port()}", threading.Event()
    with dishonest(endpoint, folder, who, listen=True, cell=CELL) as session:

        def tell() -> None:
            while not ended.wait(0.01):
                session.put(STATE.key_for(CELL), encode(msgspec.structs.replace(CELL_STATE, t_ns=time.monotonic_ns())))

        def clock(query: zenoh.Query) -> None:
            now_ns = time.monotonic_ns()
            query.reply(CLOCK.key_for(CELL), encode(ClockAnswer(received_ns=now_ns, answered_ns=now_ns)))

        def describe(query: zenoh.Query) -> None:
            query.reply(DESCRIBE.key_for(CELL), encode(golden.DESCRIPTION))

        answering = [
            session.declare_queryable(CLOCK.key_for(CELL), clock),
            session.declare_queryable(DESCRIBE.key_for(CELL), describe),
        ]
        telling = threading.Thread(target=tell)
        telling.start()
        try:
            yield endpoint
        finally:
            del answering
            ended.set()
            telling.join()


@contextmanager
def teleop(folder: Path, endpoint: str, who: str = "viewer") -> Iterator[FarhandTeleop]:
    """A device that is disconnected in the end."""
    pair, authority = folder / CELL / who, "viewers-ca" if who == "viewer" else "ca"
    files = {"ca": f"{folder}/{authority}.pem", "certificate": f"{pair}.pem", "key": f"{pair}.key"}
    device = FarhandTeleop(
        FarhandTeleopConfig(cell=CELL, remote=endpoint, joints=JOINTS, connect_timeout_s=2.0, **files)
    )
    try:
        yield device
    finally:
        if device.is_connected:
            device.disconnect()


@pytest.mark.slow
@pytest.mark.parametrize("who", ["viewer", "maintenance"])
def test_a_clients_certificate_is_no_servers(folder: Path, who: str) -> None:
    with (
        impersonated(folder, who) as endpoint,
        teleop(folder, endpoint, who) as device,
        pytest.raises(ConnectionError, match="nobody answers"),
    ):
        device.connect()


@pytest.mark.parametrize("who", ["viewer", "maintenance", "operator.anna"])
def test_an_earlier_certificate_for_every_use_is_refused_by_the_name_in_it(earlier: Path, who: str) -> None:
    named = who.replace("operator", f"operator.{CELL}") if who.startswith("operator") else f"{who}.{CELL}"
    with (
        impersonated(earlier, who) as endpoint,
        teleop(earlier, endpoint, who) as device,
        pytest.raises(ConnectionError, match=f"shows the certificate of {named}"),
    ):
        device.connect()


@pytest.mark.slow
def test_who_takes_the_cells_place_later_is_not_heard(earlier: Path) -> None:
    port = free_port()
    with teleop(earlier, f"tls/127.0.0.1:{port}") as device:
        with impersonated(earlier, "viewers-remote", port):
            device.connect()
            action(device)
        with impersonated(earlier, "viewer", port):
            time.sleep(BACK_S)
            with pytest.raises(StaleDataError, match="old"):
                device.get_action()
