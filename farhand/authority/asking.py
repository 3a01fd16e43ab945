"""A link to the sites that a command asks something of, and the state that is published there."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from common.errors import MessageError, RefusedError, TransportError
from common.link.channels import STATE, check_cell_name
from common.link.config import LinkSecurity
from common.link.request_client import PATIENCE_NS
from common.link.transport import Link, open_link
from common.messages.robot import RobotState

POLL_S = 0.05


@contextmanager
def link_to(cell: str, *endpoints: str, security: LinkSecurity) -> Iterator[Link]:
    """A link to sites; without an answer, the TransportError gives the reason if one can be found."""
    check_cell_name(cell)
    with open_link(connect=endpoints, security=security) as link:
        try:
            yield link
        except RefusedError:
            raise
        except TransportError as error:
            link.check_connected()
            if why := link.why_silent():
                raise TransportError(f"{error} {why}") from error
            raise


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
    raise TransportError(f"no state is published: is the remote site of cell {cell} running?")
