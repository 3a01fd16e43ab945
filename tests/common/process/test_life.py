"""A daemon's life: READY messages, children that die, hang or end."""

import multiprocessing
import os
import signal
import socket
import time
from pathlib import Path

import pytest
from structlog.testing import capture_logs

import common
from common.clock import ClockOffset
from common.errors import DriverError, ProcessError
from common.process.children import END, SENT_TO_ALL, ChildMain, Children, Heartbeat, ends_at_once
from common.process.service import StopFlag, notify
from lab.stage.waiting import until


def test_the_common_package_is_ours() -> None:
    assert Path(common.__file__).parent == Path(__file__).parents[3] / "common"


def test_age_is_an_upper_bound_over_the_offset() -> None:
    assert ClockOffset(offset_ns=1000, uncertainty_ns=50).age_ns(stamp_ns=1500, now_ns=700) == 250


def test_ready_reaches_the_socket_of_systemd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "notify"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(str(path))
        monkeypatch.setenv("NOTIFY_SOCKET", str(path))
        notify("READY=1")
        assert receiver.recv(64) == b"READY=1"
    monkeypatch.delenv("NOTIFY_SOCKET")
    notify("READY=1")


def beating(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    while not should_stop.wait(0.02):
        heartbeat.beat()


def waiting(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001  # the signature of a child's main
    while not should_stop.wait(0.02):
        pass


def dying(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001  # the signature of a child's main
    heartbeat.beat()
    os._exit(3)


def stubborn(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001
    heartbeat.beat()
    while True:
        time.sleep(1.0)


def test_children_start_and_end_in_order() -> None:
    children = Children("test")
    child = children.start("worker", beating)
    children.wait_ready(10.0, StopFlag())
    children.check()
    children.end()
    assert child.process.exitcode == 0


def lasting(path: Path) -> ChildMain:
    """Beats until it is asked to end, and leaves when that was."""

    def main(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        while not should_stop.wait(0.01):
            heartbeat.beat()
        path.write_text(str(time.monotonic_ns()))
        time.sleep(0.1)

    return main


@pytest.mark.slow
def test_who_started_last_is_told_to_end_first_and_a_stubborn_one_does_not_keep_it_from_the_others(
    tmp_path: Path,
) -> None:
    """What control does last needs the driver, and the driver the simulated cell."""
    children, names = Children("test"), ("cell", "driver", "control")
    for name in names:
        children.start(name, lasting(tmp_path / name))
    children.start("stubborn", stubborn)
    children.wait_ready(10.0, StopFlag())
    began = time.monotonic()
    children.end()
    assert time.monotonic() - began < 4.0
    told = [int((tmp_path / name).read_text()) for name in reversed(names)]
    assert told == sorted(told)
    assert told[1] - told[0] >= 90_000_000


@pytest.mark.parametrize("number", SENT_TO_ALL)
def test_what_systemd_sends_to_every_process_of_a_service_is_left_to_its_main_one(number: signal.Signals) -> None:
    children = Children("test")
    child = children.start("worker", beating)
    children.wait_ready(10.0, StopFlag())
    os.kill(child.process.pid or 0, number)
    beat = child.heartbeat.last_ns
    until(lambda: children.check() or child.heartbeat.last_ns >= beat + 50_000_000, "its heartbeat", 10.0)
    assert child.process.is_alive()
    children.end()
    assert child.process.exitcode == 0


def test_a_child_whose_parent_is_killed_ends_in_order(tmp_path: Path) -> None:
    def site(should_stop: StopFlag, heartbeat: Heartbeat) -> None:
        children = Children("test")
        children.start("worker", lasting(tmp_path / "ended"))
        children.wait_ready(10.0, should_stop)
        heartbeat.beat()
        should_stop.wait(60.0)

    above = Children("above")
    process = above.start("site", site).process
    above.wait_ready(10.0, StopFlag())
    process.kill()
    process.join(10.0)
    until((tmp_path / "ended").exists, "the end", 10.0)


def test_a_dead_child_is_an_error_with_its_name() -> None:
    children = Children("test")
    child = children.start("worker", dying)
    child.process.join(10.0)
    with pytest.raises(ProcessError, match=r"worker died \(exit code 3\)"):
        children.check()


def refusing(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001  # the signature of a child's main
    raise DriverError("no arm answers at address 7")


def failing(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001
    raise ValueError("x" * 5000)


def leaving(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001
    raise SystemExit("no licence")


@pytest.mark.parametrize(
    ("main", "reason"),
    [
        (refusing, r"^no arm answers at address 7$"),
        (failing, r"^test: process worker died \(exit code 1\): ValueError: xxx"),
        (leaving, r"^test: process worker died \(exit code 1\): SystemExit: no licence"),
    ],
)
def test_a_child_that_raises_leaves_its_reason(main: ChildMain, reason: str) -> None:
    children = Children("test")
    child = children.start("worker", main)
    child.process.join(10.0)
    with pytest.raises(ProcessError, match=reason):
        children.check()


def within_a_call(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001
    with ends_at_once():
        heartbeat.beat()
        while True:  # a signal handler does not end it
            time.sleep(1.0)


def test_a_child_within_a_call_that_does_not_return_ends_at_once() -> None:
    children = Children("test")
    child = children.start("worker", within_a_call)
    children.wait_ready(10.0, StopFlag())
    with capture_logs() as logs:
        children.end()
    assert child.process.exitcode == -END
    assert logs == []


def test_a_killed_child_is_noticed() -> None:
    children = Children("test")
    child = children.start("worker", beating)
    children.wait_ready(10.0, StopFlag())
    os.kill(child.process.pid or 0, signal.SIGKILL)
    child.process.join(10.0)
    with pytest.raises(ProcessError, match="worker died"):
        children.check()


def test_a_child_that_is_not_vital_may_die_or_never_be_ready() -> None:
    children = Children("test")
    children.start("worker", beating)
    children.start("extra", dying, vital=False).process.join(10.0)
    children.start("late", waiting, vital=False)
    children.wait_ready(10.0, StopFlag())
    try:
        children.check()
        assert [child.name for child in children.children] == ["worker", "late"]
    finally:
        children.end()


@pytest.mark.slow
def test_a_child_that_will_not_end_is_killed() -> None:
    children = Children("test")
    child = children.start("worker", stubborn)
    children.wait_ready(10.0, StopFlag())
    with capture_logs() as logs:
        children.end()
    child.process.join(10.0)
    assert child.process.exitcode == -signal.SIGKILL
    assert [(entry["event"], entry["log_level"]) for entry in logs] == [("had to be killed", "error")]


@pytest.mark.slow
def test_a_child_that_is_killed_while_it_starts_is_no_error() -> None:
    begun = multiprocessing.get_context("fork").Event()

    def never_ready(should_stop: StopFlag, heartbeat: Heartbeat) -> None:  # noqa: ARG001
        begun.set()
        time.sleep(60.0)

    children = Children("test")
    child = children.start("worker", never_ready)
    assert begun.wait(10.0)
    with capture_logs() as logs:
        children.end()
    child.process.join(10.0)
    assert child.process.exitcode == -signal.SIGKILL
    assert [(entry["event"], entry["log_level"]) for entry in logs] == [("ended while it was starting", "info")]


@pytest.mark.slow
def test_a_hanging_child_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    children = Children("test")
    children.start("worker", stubborn)
    children.wait_ready(10.0, StopFlag())
    monkeypatch.setattr("common.process.children.HEARTBEAT_TIMEOUT_S", 0)
    try:
        with pytest.raises(ProcessError, match="hangs"):
            children.check()
    finally:
        children.end()
