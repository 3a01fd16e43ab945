"""`farhand stop` with real certificates: whoever may stop is acknowledged, everybody else is told what to use."""

import re
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from msgspec.structs import replace
from typer.testing import CliRunner

from common.clock import NS_PER_MS
from common.errors import ConfigError, InterruptionError, TransportError
from common.messages.requests import EngagementAction, Reply
from common.messages.robot import RobotState, SessionState
from farhand.authority import engage
from farhand.authority.engage import (
    request_disengage,
    request_engage,
    request_maintenance,
    request_reset,
    request_stop,
)
from farhand.certificates.folder import CertificateOrder, create
from farhand.cli import app
from tests.common.link.secured_cell import ANNA, BEN, CELL, OPERATORS, Cell, free_port, running, secured
from tests.common.messages.golden_examples import STATE

ACKNOWLEDGED = r"STOP acknowledged at \d\d:\d\d:\d\d UTC, after \d+ ms: "
NOT = "STOP NOT ACKNOWLEDGED: the arm may still move, use the emergency stop. "


@pytest.fixture(scope="module")
def pki(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pki")
    create(folder, CertificateOrder(CELL, (), 30, (*OPERATORS, "carl")), datetime.now(UTC))
    return folder


@pytest.fixture(scope="module")
def cell(pki: Path) -> Iterator[Cell]:
    with running(secured(pki, "remote")) as cell:
        yield cell


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.link.request_client.PATIENCE_NS", 300 * NS_PER_MS)


@pytest.mark.parametrize(("who", "operator", "key"), [("operator.anna", ANNA, ANNA), ("maintenance", BEN, "")])
def test_operators_and_maintenance_stop_each_on_their_own_key(
    pki: Path, cell: Cell, who: str, operator: str, key: str
) -> None:
    before = cell.heard[key]
    words = request_stop(CELL, cell.endpoint, operator, secured(pki, who))
    assert re.match(ACKNOWLEDGED, words)
    assert cell.heard[key] > before


@pytest.mark.slow
@pytest.mark.parametrize("who", ["operator.anna", "maintenance"])
def test_where_quic_lets_nobody_in_a_stop_goes_by_tls(pki: Path, cell: Cell, who: str) -> None:
    by_quic = cell.endpoint.replace("tls/", "quic/")  # nothing answers there
    assert re.match(ACKNOWLEDGED, request_stop(CELL, by_quic, ANNA, secured(pki, who)))


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize(
    ("who", "operator", "why"),
    [
        ("operator.anna", BEN, "that key is another operator's"),
        ("operator.carl", "carl", 'links.operators there, or the router\'s, leaves out "carl"'),
    ],
)
def test_who_may_not_stop_is_told_why_and_what_to_use(pki: Path, cell: Cell, who: str, operator: str, why: str) -> None:
    with pytest.raises(TransportError) as refused:
        request_stop(CELL, cell.endpoint, operator, secured(pki, who))
    assert str(refused.value).startswith(NOT)
    assert why in str(refused.value)


@pytest.mark.slow
@pytest.mark.usefixtures("impatient")
def test_without_an_answer_a_stop_is_asked_again_until_the_time_is_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("common.link.request_client.PATIENCE_NS", 1000 * NS_PER_MS)
    asked = []
    monkeypatch.setattr("common.link.transport.Link.ask", lambda *given, **_: asked.append(given[3]))
    with pytest.raises(TransportError, match=re.escape(NOT) + "no site of cell"):
        request_stop(CELL, f"tcp/127.0.0.1:{free_port()}", ANNA)
    assert len(asked) >= 3


def test_a_stop_that_cannot_be_asked_is_a_mistake_that_names_the_emergency_stop_too() -> None:
    with pytest.raises(ConfigError, match=re.escape(NOT) + "operator 'No One'"):
        request_stop(CELL, "tcp/127.0.0.1:9", "No One")


def test_ctrl_c_before_an_answer_is_no_acknowledgement(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(engage, "ask_engagement", interrupted)
    with pytest.raises(InterruptionError, match=re.escape(NOT)):
        request_stop(CELL, f"tcp/127.0.0.1:{free_port()}", ANNA)


@pytest.fixture
def stopped(monkeypatch: pytest.MonkeyPatch) -> RobotState:
    """The state of a site that maintenance has stopped."""
    barred = {"state": SessionState.DISENGAGED, "code": "stopped", "reason": "stopped by maintenance"}
    state = replace(STATE, **barred, halted_ns=7)
    monkeypatch.setattr(engage, "newest_state", lambda *_: state)
    return state


def reset(cell: str, endpoint: str, operator: str) -> str:
    return request_reset(cell, endpoint, operator, print)


@pytest.mark.slow
@pytest.mark.usefixtures("stopped")
@pytest.mark.parametrize(
    ("ask", "begins"),
    [(request_stop, NOT), (request_disengage, "not disengaged ("), (reset, "not reset (")],
)
def test_a_reply_that_refuses_is_no_success(
    ask: Callable[[str, str, str], str], begins: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    refused = Reply(id=0, done=False, code="not_holder", reason="ben holds the lease")
    monkeypatch.setattr(engage, "ask_engagement", lambda *_, **__: refused)
    with pytest.raises(TransportError, match="not_holder") as told:
        ask(CELL, f"tcp/127.0.0.1:{free_port()}", ANNA)
    assert str(told.value).startswith(begins)


@pytest.mark.slow
def test_a_reset_says_what_it_clears_and_names_no_more_than_that(
    stopped: RobotState, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked, told = [], list[str]()

    def ask(_client: object, action: EngagementAction, seen_ns: int, *, maintenance: bool = False) -> Reply:
        asked.append((action, seen_ns, maintenance))
        assert len(told) == len(asked), "it says so first"
        return Reply(id=0, done=True, code="reset", reason="reset")

    monkeypatch.setattr(engage, "ask_engagement", ask)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    request_reset(CELL, endpoint, ANNA, told.append)
    request_maintenance(CELL, endpoint, EngagementAction.RESET, told.append)
    assert told == ["to reset: stopped by maintenance"] * 2
    told.append("an engagement says nothing before its reply")
    request_engage(CELL, endpoint, ANNA)
    reset, engaged = EngagementAction.RESET, EngagementAction.ENGAGE
    assert asked == [(reset, 7, False), (reset, 7, True), (engaged, stopped.halted_ns, False)]


@pytest.mark.parametrize(
    ("state", "code", "begins"),
    [
        (SessionState.DISENGAGED, "reset", "nothing to reset: "),
        (SessionState.DISENGAGED, "not_engaged", "nothing to reset: "),
        (SessionState.DISENGAGED, "robot_not_ready", "to reset: "),
        (SessionState.FAULT, "stopped", "to reset: "),
        (SessionState.HOLDING, "hand_lost", "to reset: "),
    ],
)
def test_a_reset_of_nothing_says_so(
    state: SessionState, code: str, begins: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engage, "newest_state", lambda *_: replace(STATE, state=state, code=code, reason="why"))
    monkeypatch.setattr(engage, "ask_engagement", lambda *_, **__: Reply(id=0, done=True, code="reset", reason="reset"))
    told: list[str] = []
    request_maintenance(CELL, f"tcp/127.0.0.1:{free_port()}", EngagementAction.RESET, told.append)
    assert told == [f"{begins}why"]


@pytest.mark.parametrize("more", [[], ["--json"]])
@pytest.mark.usefixtures("impatient")
def test_a_stop_by_maintenance_without_an_answer_names_the_emergency_stop(more: list[str]) -> None:
    asked = ["maintenance", "stop", "--remote", f"tcp/127.0.0.1:{free_port()}", *more]
    refused = CliRunner().invoke(app, asked)
    assert str(refused.exception).startswith(NOT)
    assert isinstance(refused.exception, TransportError)
    assert refused.stdout == ""


def test_a_stop_by_maintenance_that_cannot_be_asked_names_the_emergency_stop_too() -> None:
    refused = CliRunner().invoke(app, ["maintenance", "stop", "--config", "nowhere.toml"])
    assert str(refused.exception).startswith(NOT)
    assert isinstance(refused.exception, ConfigError)


@pytest.mark.slow
@pytest.mark.usefixtures("stopped")
@pytest.mark.parametrize("code", ["stopped", "fault", "robot_not_ready"])
def test_an_engagement_that_needs_a_reset_first_names_the_command(code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    refused = Reply(id=0, done=False, code=code, reason="reset it, then engage")
    monkeypatch.setattr(engage, "ask_engagement", lambda *_, **__: refused)
    with pytest.raises(TransportError, match=r"reset it, then engage \(farhand reset, or Reset on the page\)"):
        request_engage(CELL, f"tcp/127.0.0.1:{free_port()}", ANNA)
