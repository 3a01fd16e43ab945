"""A link to the sites that a command asks something of, and the state that is published there."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from common.errors import MessageError, RefusedError, SilenceError, TransportError
from common.link.channels import STATE, check_cell_name
from common.link.config import LinkSecurity
from common.link.request_client import PATIENCE_NS
from common.link.transport import Link, open_link
from common.messages.robot import RobotState

POLL_S = 0.05
QUIC_PATIENCE_S, PATIENCE_S = 0.3, 1.0  # of QUIC alone, once a session has tried to open; then of QUIC or TLS


@dataclass(frozen=True, slots=True)
class AskedSite:
    """A site that a command asks: where it should listen, what runs it there, which options name the place."""

    endpoint: str
    command: str
    named_by: str


def remote_at(endpoint: str) -> AskedSite:
    """The remote site at its control endpoint."""
    return AskedSite(endpoint, "farhand remote", "--remote, or links.control of --config")


def local_at(endpoint: str) -> AskedSite:
    """The local site of this host."""
    return AskedSite(endpoint, "farhand local", "--local, or links.local of --config")


def no_answer(whom: str, *sites: AskedSite) -> str:
    """Say what to check where none of these sites answers for a cell."""
    where = " or ".join(site.endpoint for site in sites)
    commands = " or ".join(f"'{site.command}'" for site in sites)
    options = ", and ".join(site.named_by for site in sites)
    return (
        f"no site of {whom} answers at {where}: check that {commands} runs there, and that --cell and {options}, name "
        "it; 'farhand doctor --config FILE' looks at the rest"
    )


@contextmanager
def link_to(cell: str, *sites: AskedSite, security: LinkSecurity) -> Iterator[Link]:
    """A link to sites; without an answer, the TransportError gives the reason if one can be found, else the endpoints.

    Where QUIC lets nobody in, as a stranger's packets can bring about, it is by TLS at the same port.
    """
    check_cell_name(cell)
    endpoints = tuple(site.endpoint for site in sites)
    with ExitStack() as stack:
        link = _first_up(stack, stack.enter_context(open_link(connect=endpoints, security=security)))
        try:
            yield link
        except RefusedError:
            raise
        except TransportError as error:
            link.check_connected()
            if why := link.why_silent():
                raise TransportError(f"{error} {why}") from error
            if isinstance(error, SilenceError):
                raise TransportError(no_answer(error.whom, *sites)) from error
            raise


def _first_up(stack: ExitStack, link: Link) -> Link:
    """This link, or one by TLS that the `stack` closes and that is up sooner."""
    fallback = link.tls_fallback()
    if fallback is None or _comes_up(QUIC_PATIENCE_S, link):
        return link
    endpoint, security = fallback
    by_tls = stack.enter_context(open_link(connect=(str(endpoint),), security=security))
    return by_tls if _comes_up(PATIENCE_S, by_tls, link) and not link.is_up() else link


def _comes_up(within_s: float, *links: Link) -> bool:
    """Wait until one of the links is up; return whether it is in time."""
    give_up_s = time.monotonic() + within_s
    while not (is_up := any(link.is_up() for link in links)) and time.monotonic() < give_up_s:
        time.sleep(POLL_S)
    return is_up


def newest_state(link: Link, cell: str) -> RobotState:
    """The remote site's state; TransportError where none comes in three seconds, or none of this release."""
    states = link.latest(STATE, cell)
    give_up_ns = time.monotonic_ns() + PATIENCE_NS
    while time.monotonic_ns() < give_up_ns:
        try:
            state = states.take()
        except MessageError as error:
            raise TransportError(f"the remote site's state is refused: {error}") from error
        if state is not None:
            return state
        time.sleep(POLL_S)
    raise SilenceError(f"cell {cell}")
