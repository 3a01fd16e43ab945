"""A local site without cameras: the hand that it publishes leads the tool along a given path, under a lease as ever."""

import secrets
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import structlog

from common.clock import NS_PER_S, Clock
from common.errors import FarhandError, RefusedError, TransportError
from common.host_clock import MonotonicClock
from common.link.channels import DESCRIBE, PREVIEW, STATE
from common.link.config import LinkSecurity
from common.link.credentials import check_links
from common.link.endpoints import check_free
from common.link.transport import Link, open_link
from common.messages.base import SESSION_BITS
from common.messages.requests import DescribeQuestion, Description
from common.process.log import LogFormat, start_log
from common.process.service import StopFlag
from local_site.authority.lease_client import Authority
from local_site.authority.remote_watch import RemoteWatch
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig
from local_site.preview.preview import NoCamera
from local_site.programmed.path_runs import Announcements, PathProgram, PathRuns
from local_site.runtime.loop import SampleSender
from local_site.runtime.recorder_relay import RecorderRelay

PERIOD_NS = NS_PER_S // 60
PATIENCE_NS = 30 * NS_PER_S  # for the remote site to start
ASK_AGAIN_S, LONGEST_WAIT_S = 0.5, 8.0  # each wait twice the last


def run_path(config: LocalConfig, program: PathProgram, should_stop: StopFlag, tell: Callable[[str], object]) -> None:
    """Publish the hand until asked to stop; `tell` gets what the run does, when that changes.

    It takes the place of `farhand local` on this host: the operator's page is connected to it as to that.
    TransportError while that runs, or where the remote site does not answer; FarhandError for a cell that the path is
    not for.
    """
    start_log("path", LogFormat.TEXT)
    links, wanted, clock = config.links, config.authority, MonotonicClock()
    try:
        check_links((links.remote, links.listen), links, config.bearer)
        _check_alone(links.listen, links)
        with open_link(listen=(links.listen,), connect=(links.remote,), security=links, in_lanes=True) as link:
            cell = described_cell(link, config.cell, links.remote, clock, should_stop)
            if cell is None:
                return
            program.check_cell(cell)
            session = secrets.randbits(SESSION_BITS)
            with Authority(link, config.cell, wanted.name, session, automatic=wanted.automatic) as authority:
                watch = RemoteWatch(link.latest(STATE, config.cell), session, lambda _: None)
                sender = SampleSender(config, link, authority, watch, clock)
                runs = PathRuns(program, session, partial(link.ask, DESCRIBE, config.cell, DescribeQuestion()))
                structlog.get_logger().info("ready", runs=program.name, cell=config.cell, remote=links.remote)
                beside = _Beside(RecorderRelay(config, link, authority), _no_camera(config, link, program))
                _publish(runs, program, sender, watch, beside, clock, should_stop, tell)
    except FarhandError as error:
        structlog.get_logger().error("ending", reason=str(error))
        raise


def _check_alone(endpoint: str, security: LinkSecurity) -> None:
    """TransportError where `farhand local` listens already."""
    try:
        check_free(endpoint, security)
    except RefusedError:
        raise
    except TransportError as error:
        raise TransportError(f"{error}. Stop 'farhand local' on this host: this takes its place") from error


@dataclass(frozen=True)
class _Beside:
    """The other sources of what the console shows."""

    recorder: RecorderRelay
    views: NoCamera


def _no_camera(config: LocalConfig, link: Link, program: PathProgram) -> NoCamera:
    """Says in the place of the operator's views what is run instead of a hand that is seen."""
    wires = {view: link.publisher(PREVIEW, config.cell, view, operator=config.authority.name) for view in CAMERAS[:2]}
    return NoCamera(wires, f"no camera is used: a {program.kind} path is run, {program.name}")


def described_cell(link: Link, cell: str, endpoint: str, clock: Clock, should_stop: StopFlag) -> Description | None:
    """Ask the cell at an endpoint what it is, until it answers; None when asked to stop before.

    It is asked more and more rarely. TransportError, which names the endpoint, where it has not answered in 30 s.
    """
    give_up_ns, wait_s = clock.now_ns() + PATIENCE_NS, ASK_AGAIN_S
    while not should_stop():
        found = link.ask(DESCRIBE, cell, DescribeQuestion())
        if found is not None:
            return found
        left_s = (give_up_ns - clock.now_ns()) / NS_PER_S
        if left_s <= 0:
            link.check_connected()
            cure = link.why_silent() or "start it there with 'farhand remote', or correct cell and links.remote"
            raise TransportError(f"no remote site of cell {cell} answers at {endpoint}: {cure}")
        waiting = {"cell": cell, "endpoint": endpoint, "waits_s": round(left_s)}
        structlog.get_logger().warning("the remote site does not answer", **waiting, cure="start it")
        should_stop.wait(min(wait_s, left_s))
        wait_s = min(2 * wait_s, LONGEST_WAIT_S)
    return None


def _publish(
    runs: PathRuns,
    program: PathProgram,
    sender: SampleSender,
    watch: RemoteWatch,
    beside: _Beside,
    clock: Clock,
    should_stop: StopFlag,
    tell: Callable[[str], object],
) -> None:
    due_ns, announcements = clock.now_ns(), Announcements(tell)
    while not should_stop():
        now_ns = clock.now_ns()
        watch.poll(now_ns)
        for order in program.orders():
            program.progress.order(order)
        hand = runs.hand(now_ns, watch.state if watch.is_there else None)
        sender.send_led(hand, runs.toggles)
        beside.recorder.poll(now_ns)
        beside.views.tell(now_ns)
        announcements.offer(hand.reason, now_ns)
        due_ns = max(due_ns + PERIOD_NS, now_ns)
        clock.sleep_until_ns(due_ns)
