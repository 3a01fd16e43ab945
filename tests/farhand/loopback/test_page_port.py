"""The page of a run is where it was last time; where that is taken, whoever asked for a port is told by whom."""

import os
import socket

import pytest
from typer.testing import CliRunner

from common.errors import ConfigError, TransportError
from farhand.cli import app
from farhand.loopback import page_port as room
from farhand.loopback.page_port import page_port, show_page
from farhand.loopback.plan import LoopbackOptions, plan_of
from farhand.loopback.site_process import free_ports


@pytest.fixture
def usual(monkeypatch: pytest.MonkeyPatch) -> int:
    (port,) = free_ports(1)
    monkeypatch.setattr(room, "USUAL_PORT", port)
    return port


def test_the_page_has_the_same_port_each_time(usual: int) -> None:
    assert page_port(None) == page_port(usual) == (usual, "")
    assert plan_of(LoopbackOptions()).console.load().serve.port == usual
    assert page_port(0)[0] not in (0, usual)


def test_where_it_is_taken_another_one_is_used_and_said_with_who_has_it(usual: int) -> None:
    with socket.create_server(("127.0.0.1", usual)):
        port, note = page_port(None)
        assert port not in (0, usual)
        assert note.startswith(f"port {usual} is taken by ")
        assert f"(process {os.getpid()})" in note
        assert plan_of(LoopbackOptions()).notes == (note,)
        assert plan_of(LoopbackOptions(headless=True)).notes == ()


def test_a_port_that_was_asked_for_and_is_taken_is_refused(usual: int) -> None:
    with socket.create_server(("127.0.0.1", usual)), pytest.raises(TransportError, match="has this port; end it"):
        page_port(usual)


def test_the_browser_is_opened_where_there_is_a_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) or True)
    for screen in room.SCREENS:
        monkeypatch.delenv(screen, raising=False)
    assert show_page("http://127.0.0.1:8470/").endswith("open http://127.0.0.1:8470/ yourself")
    assert opened == []
    monkeypatch.setenv("DISPLAY", ":0")
    assert show_page("http://127.0.0.1:8470/") == ""
    assert opened == ["http://127.0.0.1:8470/"]
    monkeypatch.setattr("webbrowser.open", lambda _: False)
    assert show_page("http://127.0.0.1:8470/").startswith("no browser can be opened from here")


@pytest.mark.parametrize(
    ("arguments", "seconds", "opens"),
    [([], 30.0, False), (["--open"], 0.0, True), (["--open", "--seconds", "9"], 9.0, True)],
)
def test_with_the_browser_open_a_run_lasts_until_ctrl_c(
    arguments: list[str], seconds: float, opens: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[float, bool]] = []
    monkeypatch.setattr(
        "farhand.loopback.measured_run.run_loopback",
        lambda options, *_, shows, **__: seen.append((options.seconds, shows is show_page)),
    )
    assert CliRunner().invoke(app, ["loopback", *arguments]).exit_code == 0
    assert seen == [(seconds, opens)]


@pytest.mark.parametrize("wish", [["--open"], ["--port", "0"]])
def test_a_page_that_is_left_out_cannot_be_shown(wish: list[str]) -> None:
    done = CliRunner().invoke(app, ["loopback", "--headless", *wish])
    assert isinstance(done.exception, ConfigError)
