"""Asks a site for something that must happen once, on behalf of a person at a terminal."""

import secrets
import time
from collections.abc import Callable
from typing import TypeVar

from common.clock import NS_PER_S, RoundTrip
from common.errors import TransportError
from common.link.channels import Procedure
from common.link.transport import Link
from common.messages.requests import Reply, Request

Q = TypeVar("Q", bound=Request)
R = TypeVar("R", bound=Reply)

PATIENCE_NS = 3 * NS_PER_S
POLL_S = 0.05
REQUEST_BITS = 62


def ask_remote(link: Link, cell: str, procedure: Procedure[Q, R], make: Callable[[int, int], Q]) -> R:
    """The remote site's reply to `make(id, deadline_ns)`; TransportError when it does not answer in three seconds."""
    give_up_ns = time.monotonic_ns() + PATIENCE_NS
    trip = _round_trip(link, cell, give_up_ns)
    request = make(secrets.randbits(REQUEST_BITS), give_up_ns + trip.offset_ns)
    return _request(link, cell, procedure, request, give_up_ns)


def ask_local(link: Link, cell: str, procedure: Procedure[Q, R], make: Callable[[int, int], Q]) -> R:
    """The reply of the local site of this host, whose clock is ours; TransportError as above."""
    give_up_ns = time.monotonic_ns() + PATIENCE_NS
    return _request(link, cell, procedure, make(secrets.randbits(REQUEST_BITS), give_up_ns), give_up_ns)


def _request(link: Link, cell: str, procedure: Procedure[Q, R], request: Q, give_up_ns: int) -> R:
    """The reply; where nobody answers, the reason if one is to be found."""
    try:
        return link.request(procedure, cell, request, give_up_ns)
    except TransportError:
        link.check_connected()
        raise


def _round_trip(link: Link, cell: str, give_up_ns: int) -> RoundTrip:
    """The remote site's clock: a deadline must be told in it."""
    while time.monotonic_ns() < give_up_ns:
        trip = link.round_trip(cell)
        if trip is not None:
            return trip
        time.sleep(POLL_S)
    link.check_connected()
    raise TransportError(f"nobody answered: is the remote site of cell {cell} running?")
