"""A port that cannot be listened on is refused with the program that has it, wherever it is bound."""

import errno
import os
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from common.clock import FakeClock
from common.errors import FarhandError
from common.link.config import ON_THIS_HOST, LinkSecurity, TlsConfig
from common.link.endpoints import check_free
from common.link.port_holders import holder_of_device, listener_on, why_not_bound
from farhand.calibration.latency.page import PatternPage
from local_site.console.config import ServeConfig
from local_site.console.server import bind

SECURED = LinkSecurity(tls=TlsConfig(ca="ca.pem", certificate="own.pem", key="own.key"))
OURS = f"(process {os.getpid()}) has this port; end it, or choose another"


@pytest.fixture
def taken() -> Iterator[int]:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening.getsockname()[1]


@pytest.mark.parametrize(
    "listen",
    [
        lambda port: check_free(f"tcp/127.0.0.1:{port}", ON_THIS_HOST),
        lambda port: bind(ServeConfig(port=port)),
        lambda port: PatternPage(FakeClock(), "token", port),
    ],
)
def test_a_taken_port_names_its_program(listen: Callable[[int], object], taken: int) -> None:
    with pytest.raises(FarhandError) as refused:
        listen(taken)
    assert OURS in str(refused.value)


def test_so_does_a_port_that_is_taken_for_datagrams() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as waiting:
        waiting.bind(("127.0.0.1", 0))
        port = waiting.getsockname()[1]
        with pytest.raises(FarhandError) as refused:
            check_free(f"quic/127.0.0.1:{port}", SECURED)
    assert OURS in str(refused.value)


def test_what_is_no_taken_port_is_told_as_it_is() -> None:
    error = OSError(errno.EACCES, "Permission denied")
    assert why_not_bound(error, 80) == "Permission denied; choose another"


def test_who_cannot_be_seen_is_not_named(monkeypatch: pytest.MonkeyPatch, taken: int) -> None:
    monkeypatch.setattr("common.link.port_holders._open_files", lambda _: iter(()))
    assert listener_on(taken) == ""
    error = OSError(errno.EADDRINUSE, "Address already in use")
    assert why_not_bound(error, taken).startswith("a program that this user may not see has this port")


@pytest.fixture
def processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A /proc whose process 7 has the device /dev/null open, and has no name yet."""
    (tmp_path / "7" / "fd").mkdir(parents=True)
    (tmp_path / "7" / "fd" / "3").symlink_to("/dev/null")
    monkeypatch.setattr("common.link.port_holders.PROC", tmp_path)
    return tmp_path / "7"


def test_a_process_that_ends_while_it_is_looked_at_holds_nothing(processes: Path) -> None:
    assert list(processes.iterdir()) == [processes / "fd"]
    assert holder_of_device(Path("/dev/null")) == ""


def test_a_name_that_is_cut_within_a_letter_is_told(processes: Path) -> None:
    (processes / "cmdline").write_bytes(b"fernbedienung-\xc3\xbcber-alles")
    (processes / "comm").write_bytes(b"fernbedienung-\xc3\n")
    assert holder_of_device(Path("/dev/null")) == "fernbedienung-\ufffd (process 7)"
