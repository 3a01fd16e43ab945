"""Shows who holds the lease of a cell, and sends the operator's requests about it to their own local site."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import TransportError
from common.link.channels import OPERATE
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.request_client import RequestClient
from common.messages.requests import SILENT, WAITING, OperatorAction, OperatorRequest
from common.messages.robot import Asker, LeaseState, RobotState
from farhand.authority.asking import link_to, local_at, newest_state, remote_at
from local_site.authority.lease_policy import KEEP_ASKING_NS

TAKE_AGAIN_S = 1.0


def seen_state(cell: str, endpoint: str, security: LinkSecurity = ON_THIS_HOST) -> RobotState:
    """The remote site's newest state; TransportError when it publishes none."""
    with link_to(cell, remote_at(endpoint), security=security) as link:
        return newest_state(link, cell)


def readiness_words(state: RobotState) -> str:
    """Say whether the arm may be engaged, and why not."""
    return f"{'ready' if state.readiness.ready else 'not ready'} ({state.readiness.code}): {state.readiness.reason}"


def holder_words(lease: LeaseState, now_ns: int) -> str:
    """For how long the lease's holder has it, at a time of the remote site."""
    return f"{(lease.expires_ns - now_ns) / NS_PER_S:.1f} s until it expires or is renewed"


def asker_words(lease: LeaseState) -> str | None:
    """Who asks for the lease, and what its holder types to consent; None where nobody does."""
    if (asker := lease.asked_by) is None:
        return None
    return f"{asker} asks for it; {lease.holder} consents with: farhand lease give {asker.name}"


def describe_lease(state: RobotState) -> list[str]:
    """The lease and the clocks in words, a line for each."""
    lease, ready = state.lease, readiness_words(state)
    if lease is None:
        return ["nobody holds the lease", ready]
    words = [f"{lease} holds the lease, {holder_words(lease, state.t_ns)}"]
    if (asks := asker_words(lease)) is not None:
        words.append(asks)
    if state.clock is not None:
        words.append(
            f"clocks: remote minus local {state.clock.remote_minus_local_ns / 1e6:.3f} ms, "
            f"sure to {state.clock.uncertainty_ns / 1e6:.3f} ms"
        )
    return [*words, ready]


def lease_builtins(state: RobotState) -> dict[str, Any]:
    """The same for programs; None for what there is not."""
    lease, clock, readiness = state.lease, state.clock, state.readiness
    asked_by = lease.asked_by if lease is not None else None
    return {
        "holder": None if lease is None else str(lease),
        "expires_in_s": None if lease is None else (lease.expires_ns - state.t_ns) / NS_PER_S,
        "asked_by": None if asked_by is None else str(asked_by),
        "clock_offset_ms": None if clock is None else clock.remote_minus_local_ns / NS_PER_MS,
        "clock_uncertainty_ms": None if clock is None else clock.uncertainty_ns / NS_PER_MS,
        "ready": readiness.ready,
        "code": readiness.code,
        "reason": readiness.reason,
    }


def find_asker(cell: str, endpoint: str, name: str, security: LinkSecurity = ON_THIS_HOST) -> Asker:
    """The operator of this name who asks for the lease at the remote site; TransportError when that is not who asks."""
    with link_to(cell, remote_at(endpoint), security=security) as link:
        lease = newest_state(link, cell).lease
    asker = lease.asked_by if lease is not None else None
    if asker is None or asker.name != name:
        raise TransportError(f"{asker or 'nobody'} asks for the lease now, not {name}: nothing was handed over")
    return asker


def act_on_lease(
    cell: str,
    endpoint: str,
    operator: str,
    action: OperatorAction,
    to: Asker | None = None,
    security: LinkSecurity = ON_THIS_HOST,
) -> str:
    """The reply of the operator's local site at `endpoint`; TransportError with its code when it refuses.

    `to` is who asks for the lease that is handed over.
    """
    with link_to(cell, local_at(endpoint), security=security) as link:
        client = RequestClient(link, cell, operator=operator)
        reply = client.ask(OPERATE, partial(OperatorRequest, action=action, to=to))
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason


def take_lease(
    cell: str, endpoint: str, operator: str, tell: Callable[[str], None], security: LinkSecurity = ON_THIS_HOST
) -> str:
    """Have the operator's local site take the lease, and wait for its holder's consent, for a minute; the reply.

    `tell` gets whom it waits for. TransportError when it is refused, or nobody consents.
    """
    told, give_up_ns = "", time.monotonic_ns() + KEEP_ASKING_NS
    with link_to(cell, local_at(endpoint), security=security) as link:
        client = RequestClient(link, cell, operator=operator)
        while True:
            reply = client.ask(OPERATE, partial(OperatorRequest, action=OperatorAction.TAKE))
            if reply.done:
                return reply.reason
            if reply.code != WAITING and not (told and reply.code == SILENT):
                raise TransportError(f"refused ({reply.code}): {reply.reason}")
            if time.monotonic_ns() > give_up_ns:
                raise TransportError(f"nobody has handed the lease over ({reply.code}): {reply.reason}")
            if reply.code == WAITING and reply.reason != told:
                told = reply.reason
                tell(f"waiting: {told}")
            time.sleep(TAKE_AGAIN_S)
