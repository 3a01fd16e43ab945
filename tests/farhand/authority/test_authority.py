"""The local site's standing over a real link: clock, description, lease and consent, and sites of another protocol."""

import threading
import time
from contextlib import ExitStack, contextmanager
from types import SimpleNamespace

import msgpack
import msgspec
import pytest
from structlog.testing import capture_logs

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import MessageError, RefusedError, TransportError
from common.host_clock import MonotonicClock
from common.link import transport
from common.link.channels import CLOCK, DESCRIBE, TROUBLE
from common.link.remote_clock import RemoteClock
from common.link.transport import CLOSE_PATIENCE_S, open_link
from common.messages.base import PROTOCOL_VERSION
from common.messages.codec import decode, encode
from common.messages.requests import ClockQuestion, DescribeQuestion, Description, OperatorAction, TroubleReport
from common.messages.robot import Asker
from farhand.authority.lease import act_on_lease, describe_lease, take_lease
from farhand.loopback.site_process import free_ports
from lab.stage.waiting import until
from local_site.authority.lease_client import END_PATIENCE_S, Authority
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.request_server import RequestServer, describe
from remote_site.session.lease import LeaseServer
from tests.present import present

CELL = "test"
PATIENCE_S = 10.0


def endpoint():
    return f"tcp/127.0.0.1:{free_ports(1)[0]}"


@pytest.fixture(scope="module")
def description():
    config = RemoteConfig(cell=CELL)
    model = ArmModel.from_urdf(config.robot.urdf, config.robot.tool_frame, config.robot.tool_T_tcp)
    return describe(config, model, JointLimits.from_model(model, config.robot))


class AheadClock(MonotonicClock):
    """The clock of a host that was started an hour earlier."""

    def now_ns(self):
        return super().now_ns() + 3600 * NS_PER_S


class Cell:
    """A remote site that is nothing but its request server, on a thread."""

    def __init__(self, stack, description):
        self.endpoint = endpoint()
        self.clock = AheadClock()
        self.leases = LeaseServer(2 * NS_PER_S, 1000)
        self.refused: list[MessageError] = []
        self._stop, self.hang = threading.Event(), threading.Event()
        self.link = stack.enter_context(open_link(listen=(self.endpoint,)))
        self._desk = RequestServer(
            self.link, description, self.leases, self.clock, self.refused.append, ("anna", "ben")
        )
        thread = threading.Thread(target=self._run)
        thread.start()
        stack.callback(thread.join)
        stack.callback(self._stop.set)

    def _run(self):
        while not self._stop.wait(0.004):
            if not self.hang.is_set():
                self._desk.poll(engaged=False)

    @property
    def holder(self):
        lease = self.leases.current(self.clock.now_ns())
        return lease.holder.name if lease is not None else None


@pytest.fixture
def stack():
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def cell(stack, description):
    return Cell(stack, description)


@contextmanager
def local_site(cell, name, session, automatic=True):
    """A local site that is nothing but its standing, and where it listens."""
    listen = endpoint()
    with (
        open_link(listen=(listen,), connect=(cell.endpoint,)) as link,
        Authority(link, CELL, name, session, automatic=automatic) as authority,
    ):
        yield authority, listen


def lease_of(authority):
    return authority.lease_and_clock(time.monotonic_ns()).lease


def test_the_clock_offset_is_found_and_its_error_lies_within_its_uncertainty(stack, cell):
    authority, _ = stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: authority.lease_and_clock(time.monotonic_ns()).clock is not None, "the clock")
    clock = authority.lease_and_clock(time.monotonic_ns()).clock
    assert abs(clock.remote_minus_local_ns - 3600 * NS_PER_S) <= clock.uncertainty_ns < 200 * NS_PER_MS
    assert 0 <= cell.clock.now_ns() - clock.measured_ns < 5 * NS_PER_S


@pytest.mark.slow
def test_the_lease_is_acquired_renewed_beyond_its_duration_and_given_back_at_the_end(cell):
    with local_site(cell, "anna", 7) as (authority, _):
        until(lambda: lease_of(authority) == 1000, "the lease")
        begin_ns = cell.clock.now_ns()
        until(lambda: cell.clock.now_ns() - begin_ns > 2.2 * NS_PER_S, "its duration")
        assert lease_of(authority) == 1000
        assert cell.holder == "anna"
    assert cell.holder is None


@pytest.mark.slow
def test_a_site_ends_soon_although_the_remote_site_does_not_answer_any_more(stack, cell):
    link = stack.enter_context(open_link(connect=(cell.endpoint,)))
    with capture_logs():
        authority = Authority(link, CELL, "anna", 7, automatic=True)
        with authority:
            until(lambda: lease_of(authority), "the lease")
            cell.hang.set()
            time.sleep(0.3)
            began = time.monotonic()
        assert time.monotonic() - began < END_PATIENCE_S + 0.2
        link.close()
        assert time.monotonic() - began < END_PATIENCE_S + CLOSE_PATIENCE_S + 0.3
        authority._thread.join(PATIENCE_S)
        assert not authority._thread.is_alive()


def test_a_link_is_closed_in_time_whatever_its_neighbours_do(stack, monkeypatch):
    link = stack.enter_context(open_link(listen=(endpoint(),)))
    slow = threading.Event()
    stack.callback(slow.set)
    monkeypatch.setattr(link, "_session", SimpleNamespace(is_closed=slow.is_set, close=lambda: slow.wait(PATIENCE_S)))
    began = time.monotonic()
    link.close()
    assert CLOSE_PATIENCE_S <= time.monotonic() - began < CLOSE_PATIENCE_S + 0.3


@pytest.mark.slow
def test_a_second_operator_is_refused_with_the_holders_name_until_the_holder_consents(stack, cell):
    anna, annas = stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: cell.holder == "anna", "anna's lease")
    ben, bens = stack.enter_context(local_site(cell, "ben", 8))
    with pytest.raises(
        TransportError, match=r"waiting\): anna \(site 7\) holds the lease.*lease give ben.*asks for 60 s"
    ):
        until(lambda: "silent" not in taken(bens), "an answer")
    assert lease_of(ben) == 0
    assert "ben" in act_on_lease(CELL, annas, "anna", OperatorAction.GIVE, Asker("ben", 8))
    until(lambda: lease_of(ben) == 1001, "ben's lease")
    assert lease_of(anna) == 0
    assert cell.holder == "ben"
    with pytest.raises(TransportError, match=r"old_lease|not_holder"):
        act_on_lease(CELL, annas, "anna", OperatorAction.GIVE, Asker("ben", 8))


@pytest.mark.slow
def test_consent_for_somebody_who_does_not_ask_any_more_is_void(stack, cell):
    anna, annas = stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: cell.holder == "anna", "anna's lease")
    _ben, bens = stack.enter_context(local_site(cell, "ben", 8))
    with pytest.raises(TransportError, match="waiting"):
        until(lambda: "silent" not in taken(bens), "an answer")
    for shown in (None, Asker("carl", 9), Asker("ben", 9), Asker("carl", 8)):
        with pytest.raises(TransportError, match=r"asker_changed\): ben \(site 8\) asks for the lease now"):
            act_on_lease(CELL, annas, "anna", OperatorAction.GIVE, shown)
    assert (cell.holder, lease_of(anna)) == ("anna", 1000)


def taken(local, operator="ben"):
    """The output of `lease take`; empty while the site does not know the cell yet."""
    try:
        return act_on_lease(CELL, local, operator, OperatorAction.TAKE)
    except TransportError as error:
        if "silent" in str(error):
            return str(error)
        raise


def test_the_holder_and_who_asks_are_told_apart_by_their_sites():
    state = golden.STATE
    asked = msgspec.structs.replace(present(state.lease), holder="anna", session=0x7F, asked_by=Asker("anna", 0x80))
    words = describe_lease(msgspec.structs.replace(state, lease=asked))
    assert words[0].startswith("anna (site 7f) holds the lease, ")
    assert words[1] == "anna (site 80) asks for it; anna consents with: farhand lease give anna"


@pytest.mark.slow
def test_lease_take_says_whom_it_waits_for_and_waits_for_the_consent(stack, cell):
    _anna, annas = stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: cell.holder == "anna", "anna's lease")
    ben, bens = stack.enter_context(local_site(cell, "ben", 8, automatic=False))
    until(lambda: ben.lease_and_clock(time.monotonic_ns()).clock is not None, "the clock")
    told: list[str] = []
    consent = threading.Timer(1.5, act_on_lease, (CELL, annas, "anna", OperatorAction.GIVE, Asker("ben", 8)))
    consent.start()
    assert take_lease(CELL, bens, "ben", told.append) == "the lease of this cell is yours"
    consent.join()
    assert len(told) == 1
    assert told[0].startswith("waiting: anna (site 7) holds the lease, and hands it over with: farhand lease give ben")
    until(lambda: lease_of(ben) == 1001, "ben's lease")


@pytest.mark.slow
def test_lease_take_ends_when_nobody_consents_or_nobody_answers(stack, cell, monkeypatch):
    monkeypatch.setattr("farhand.authority.lease.KEEP_ASKING_NS", NS_PER_S)
    stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: cell.holder == "anna", "anna's lease")
    ben, bens = stack.enter_context(local_site(cell, "ben", 8))
    until(lambda: ben.lease_and_clock(time.monotonic_ns()).clock is not None, "the clock")
    told: list[str] = []
    with pytest.raises(TransportError, match=r"nobody has handed the lease over \(waiting\): anna \(site 7\)"):
        take_lease(CELL, bens, "ben", told.append)
    assert len(told) == 1
    lonely = endpoint()
    link = stack.enter_context(open_link(listen=(lonely,)))
    stack.enter_context(Authority(link, CELL, "carl", 9, automatic=True))
    with pytest.raises(TransportError, match=r"refused \(silent\)"):
        take_lease(CELL, lonely, "carl", told.append)


@pytest.mark.slow
def test_after_a_handover_the_log_says_that_it_is_not_asked_for_automatically_and_a_refusal_once(stack, cell):
    with capture_logs() as log:
        anna, annas = stack.enter_context(local_site(cell, "anna", 7))
        until(lambda: cell.holder == "anna", "anna's lease")
        ben, bens = stack.enter_context(local_site(cell, "ben", 8))
        with pytest.raises(TransportError, match="waiting"):
            until(lambda: "silent" not in taken(bens), "an answer")
        until(lambda: cell.leases.asker(cell.clock.now_ns()) is not None, "ben's question")
        time.sleep(2.2)  # ben's site asks once a second
        act_on_lease(CELL, annas, "anna", OperatorAction.GIVE, Asker("ben", 8))
        until(lambda: lease_of(ben) == 1001, "ben's lease")
    events = [line["event"] for line in log]
    assert events.count("the lease is not asked for automatically any more") == 2, (
        "of ben's site when refused, of anna's"
    )
    assert len([line for line in log if line.get("code") == "not_holder"]) == 1
    assert lease_of(anna) == 0


def test_a_silent_remote_site_is_told_with_its_endpoint(stack, monkeypatch):
    monkeypatch.setattr("local_site.authority.lease_client.ROUNDS_TO_WARN", 1)
    lonely = endpoint()
    with capture_logs() as log:
        link = stack.enter_context(open_link(connect=(lonely,)))
        stack.enter_context(Authority(link, CELL, "carl", 9, automatic=True))
        until(lambda: any(line["event"] == "the remote site does not answer" for line in log), "the warning")
    assert next(line["endpoint"] for line in log if "does not answer" in line["event"]) == lonely


def test_consent_without_anyone_who_asks_is_refused(stack, cell):
    anna, annas = stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: cell.holder == "anna", "anna's lease")
    with pytest.raises(TransportError, match="nobody_asks"):
        act_on_lease(CELL, annas, "anna", OperatorAction.GIVE, Asker("ben", 8))
    assert lease_of(anna) == 1000


@pytest.mark.slow
def test_a_released_lease_is_free_and_not_asked_for_again_by_itself(stack, cell):
    anna, annas = stack.enter_context(local_site(cell, "anna", 7))
    until(lambda: cell.holder == "anna", "anna's lease")
    assert act_on_lease(CELL, annas, "anna", OperatorAction.RELEASE) == "the lease is given back"
    until(lambda: lease_of(anna) == 0, "no lease")
    begin_ns = cell.clock.now_ns()
    until(lambda: cell.clock.now_ns() - begin_ns > 1.2 * NS_PER_S, "a while")
    assert cell.holder is None


def test_what_an_operators_site_reports_of_the_link_is_logged_here(stack, cell):
    link = stack.enter_context(open_link(connect=(cell.endpoint,)))
    with capture_logs() as lines:
        until(lambda: link.ask(TROUBLE, CELL, TroubleReport(reason="UDP is blocked"), operator="anna"), "the answer")
    told = next(line for line in lines if "reports trouble" in line["event"])
    assert (told["log_level"], told["operator"], told["reason"]) == ("warning", "anna", "UDP is blocked")


def test_the_description_names_joints_cameras_rates_and_software(stack, cell, description):
    link = stack.enter_context(open_link(connect=(cell.endpoint,)))
    answers = []
    until(lambda: answers.append(link.ask(DESCRIBE, CELL, DescribeQuestion())) or answers[-1] is not None, "an answer")
    assert answers[-1] == decode(encode(description), Description, DESCRIBE.max_bytes)
    assert [joint.name for joint in description.joints] == [f"joint_{k}" for k in range(1, 7)]
    assert all(joint.lower < joint.upper and joint.speed > 0 for joint in description.joints)
    assert {camera.name for camera in description.cameras} == {"front_high", "front_low", "side", "gripper"}
    assert description.control_hz == 250.0


def test_a_question_in_another_version_is_refused_with_a_sentence_at_both_ends(stack, cell, monkeypatch):
    link = stack.enter_context(open_link(connect=(cell.endpoint,)))
    until(lambda: RemoteClock(link, CELL).measure() is not None, "the cell")
    time.sleep(0.02)  # requests that follow each other immediately are dropped
    monkeypatch.setattr(transport, "encode", lambda _question: msgpack.packb([PROTOCOL_VERSION + 1]))
    with pytest.raises(RefusedError, match=f"this side speaks {PROTOCOL_VERSION}: install the same release"):
        link.ask(CLOCK, CELL, ClockQuestion())
    assert [error.reason for error in cell.refused] == ["version"]
    assert "install the same release" in str(cell.refused[0])


def test_a_cell_of_another_version_ends_the_local_site_with_a_sentence(stack):
    where = endpoint()
    link = stack.enter_context(open_link(listen=(where,)))
    newer = msgpack.packb([PROTOCOL_VERSION + 1, 1, 1, 27])

    def answer(query):
        with query:
            query.reply(CLOCK.key_for(CELL), newer)

    link._session.declare_queryable(CLOCK.key_for(CELL), answer)
    cell = type("Elsewhere", (), {"endpoint": where})
    authority, _ = stack.enter_context(local_site(cell, "anna", 7))

    def refused():
        try:
            authority.lease_and_clock(time.monotonic_ns())
        except RefusedError as error:
            return "install the same release" in str(error)
        return False

    until(refused, "the refusal")


def test_nobody_there_is_no_lease_and_no_clock():
    cell = type("Nowhere", (), {"endpoint": endpoint()})
    with local_site(cell, "anna", 7) as (authority, listen):
        with pytest.raises(TransportError, match="silent"):
            act_on_lease(CELL, listen, "anna", OperatorAction.TAKE)
        assert authority.lease_and_clock(time.monotonic_ns()).lease == 0
        assert authority.lease_and_clock(time.monotonic_ns()).clock is None


@pytest.mark.slow
def test_a_site_that_is_refused_while_it_runs_ends_with_the_reason(stack, monkeypatch):
    where = endpoint()
    link = stack.enter_context(open_link(connect=(where,)))
    monkeypatch.setattr("local_site.authority.lease_client.ROUNDS_TO_DOUBT", 2)
    monkeypatch.setattr("common.link.transport.refusal", lambda place, _: f"{place} refuses us")
    authority = stack.enter_context(Authority(link, CELL, "anna", 7, automatic=True))
    told: list[str] = []

    def ended() -> bool:
        try:
            authority.lease_and_clock(time.monotonic_ns())
        except RefusedError as error:
            told.append(str(error))
        return bool(told)

    until(ended, "the end")
    assert told[0] == f"{where} refuses us"
