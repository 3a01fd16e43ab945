"""Asks the remote site to let the arm follow the hand or to end that, to stop it, and to reset it."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime

from common.clock import NS_PER_MS
from common.errors import ConfigError, FarhandError, InterruptionError, TransportError
from common.link.channels import STOP, check_cell_name
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.engagement_client import ask_engagement
from common.link.remote_clock import RemoteClock
from common.link.request_client import RequestClient
from common.link.transport import Link
from common.messages.requests import EngagementAction, Reply
from common.messages.robot import SessionState
from farhand.authority.asking import link_to, newest_state, remote_at
from farhand.exits import NOT_STOPPED
from local_site.authority.config import host_operator

RESET_FIRST = ("stopped", "fault", "robot_not_ready")
TO_RESET = " (farhand reset, or Reset on the page)"


def request_engage(cell: str, endpoint: str, operator: str = "", security: LinkSecurity = ON_THIS_HOST) -> str:
    """The remote site's reply to an operator (this host's by default); TransportError when it refuses."""
    reply = _ask_as_operator(cell, endpoint, operator, EngagementAction.ENGAGE, security)
    if not reply.done:
        cure = TO_RESET if reply.code in RESET_FIRST else ""
        raise TransportError(f"not engaged ({reply.code}): {reply.reason}{cure}")
    return f"engaged: {reply.reason}"


def request_disengage(cell: str, endpoint: str, operator: str = "", security: LinkSecurity = ON_THIS_HOST) -> str:
    """The remote site's reply to an operator (this host's by default); TransportError when it refuses."""
    reply = _ask_as_operator(cell, endpoint, operator, EngagementAction.DISENGAGE, security)
    if not reply.done:
        raise TransportError(f"not disengaged ({reply.code}): {reply.reason}")
    return reply.reason


def request_reset(
    cell: str, endpoint: str, operator: str, tell: Callable[[str], None], security: LinkSecurity = ON_THIS_HOST
) -> str:
    """The remote site's reply to an operator (this host's where empty); TransportError when it refuses.

    `tell` gets beforehand what is reset, such as who has stopped the arm; what comes after that is not.
    """
    reply = _ask_as_operator(cell, endpoint, operator, EngagementAction.RESET, security, tell)
    if not reply.done:
        raise TransportError(f"not reset ({reply.code}): {reply.reason}")
    return reply.reason


def request_stop(cell: str, endpoint: str, operator: str = "", security: LinkSecurity = ON_THIS_HOST) -> str:
    """The acknowledgement of a stop, with how long it took, for whoever may stop: an operator, or maintenance.

    It is asked again until it is acknowledged, for three seconds. TransportError when it is not, ConfigError when it
    cannot be asked, InterruptionError after Ctrl-C; all name the emergency stop.
    """
    began_ns = time.monotonic_ns()
    with or_unacknowledged():
        name = check_cell_name(operator or host_operator(), "operator")
        with link_to(cell, remote_at(endpoint), security=security) as link:
            client = RequestClient(link, cell, operator=name)
            reply = ask_engagement(client, EngagementAction.STOP, maintenance=not link.may_ask(STOP))
        if not reply.done:
            raise TransportError(f"{reply.reason} ({reply.code})")
    took_ms, at = (time.monotonic_ns() - began_ns) / NS_PER_MS, datetime.now(UTC)
    return f"STOP acknowledged at {at:%H:%M:%S} UTC, after {took_ms:.0f} ms: {reply.reason}{TO_RESET}"


@contextmanager
def or_unacknowledged() -> Iterator[None]:
    """Says of whatever keeps a stop from its acknowledgement, Ctrl-C too, that it has none."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(_unacknowledged(str(error))) from error
    except FarhandError as error:
        raise TransportError(_unacknowledged(str(error))) from error
    except KeyboardInterrupt as error:
        raise InterruptionError(_unacknowledged("interrupted before an answer came")) from error


def _unacknowledged(why: str) -> str:
    return f"{NOT_STOPPED} {why}"


def _ask_as_operator(
    cell: str,
    endpoint: str,
    operator: str,
    action: EngagementAction,
    security: LinkSecurity,
    tell: Callable[[str], None] = lambda _: None,
) -> Reply:
    name = check_cell_name(operator or host_operator(), "operator")
    with link_to(cell, remote_at(endpoint), security=security) as link:
        seen_ns = _look(link, cell, action, tell)
        return ask_engagement(RequestClient(link, cell, RemoteClock(link, cell), operator=name), action, seen_ns)


def request_maintenance(
    cell: str,
    endpoint: str,
    action: EngagementAction,
    tell: Callable[[str], None],
    security: LinkSecurity = ON_THIS_HOST,
) -> str:
    """The remote site's reply to a maintenance request; TransportError when it refuses.

    `tell` gets beforehand what a reset clears, as in `request_reset`.
    """
    with link_to(cell, remote_at(endpoint), security=security) as link:
        seen_ns = _look(link, cell, action, tell)
        reply = ask_engagement(RequestClient(link, cell, RemoteClock(link, cell)), action, seen_ns, maintenance=True)
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason


def _look(link: Link, cell: str, action: EngagementAction, tell: Callable[[str], None]) -> int:
    """The newest halt of the state there, for what has to name it; `tell` gets what a reset is about to clear."""
    if action not in (EngagementAction.ENGAGE, EngagementAction.RESET):
        return 0
    state = newest_state(link, cell)
    if action is EngagementAction.RESET:
        is_barred = state.state is not SessionState.DISENGAGED or state.code in RESET_FIRST
        tell(f"{'to reset' if is_barred else 'nothing to reset'}: {state.reason}")
    return state.halted_ns
