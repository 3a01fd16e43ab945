"""Who may operate a cell: shows the lease, and does what an operator decides about it at the own local site."""

import time

from common.clock import NS_PER_S
from common.errors import MessageError, TransportError
from common.link.channels import OPERATE, STATE, check_cell_name
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.transport import Link, open_link
from common.messages.requests import OperatorAction, OperatorRequest
from common.messages.robot import RobotState
from farhand.authority.asking import PATIENCE_NS, POLL_S, ask_local


def show_lease(cell: str, endpoint: str, security: LinkSecurity = ON_THIS_HOST) -> str:
    """Who holds the lease, for how long still, who asks for it, and how well the clocks are known."""
    check_cell_name(cell)
    with open_link(connect=(endpoint,), security=security) as link:
        return describe_lease(_state(link, cell))


def describe_lease(state: RobotState) -> str:
    """The lease and the clocks in words."""
    ready = f"{'ready' if state.readiness.ready else 'not ready'} ({state.readiness.code}): {state.readiness.reason}"
    if state.lease is None:
        return f"nobody holds the lease\n{ready}"
    left_s = (state.lease.expires_ns - state.t_ns) / NS_PER_S
    words = [f"{state.lease.holder} holds the lease, {left_s:.1f} s until it expires or is renewed"]
    if state.lease.asked_by is not None:
        words.append(f"{state.lease.asked_by} asks for it; {state.lease.holder} consents by: farhand lease give")
    if state.clock is not None:
        words.append(
            f"clocks: remote minus local {state.clock.remote_minus_local_ns / 1e6:.3f} ms, "
            f"sure to {state.clock.uncertainty_ns / 1e6:.3f} ms"
        )
    return "\n".join([*words, ready])


def act_on_lease(cell: str, endpoint: str, action: OperatorAction, security: LinkSecurity = ON_THIS_HOST) -> str:
    """What came of the operator's act, as the local site at `endpoint` tells; TransportError with code when refused."""
    check_cell_name(cell)

    def request(number: int, deadline_ns: int) -> OperatorRequest:
        return OperatorRequest(id=number, deadline_ns=deadline_ns, action=action)

    with open_link(connect=(endpoint,), security=security) as link:
        reply = ask_local(link, cell, OPERATE, request)
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason


def _state(link: Link, cell: str) -> RobotState:
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
    link.check_connected()
    raise TransportError(f"nobody tells a state: is the remote site of cell {cell} running?")
