"""Asks the recorders of both sites, as the lease's holder, to record, and to bound and label episodes."""

from common.clock import NS_PER_S
from common.errors import SilenceError, TransportError
from common.link.channels import check_cell_name
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.record_client import RecordClient
from common.link.remote_clock import RemoteClock
from common.link.request_client import RequestClient
from common.messages.recording import EpisodeOutcome
from common.messages.requests import SILENT, RecordAction
from farhand.authority.asking import link_to, local_at, remote_at

LOCAL_PATIENCE_NS = NS_PER_S


def request_record(
    cell: str,
    remote: str,
    local: str,
    operator: str,
    action: RecordAction,
    task: str = "",
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN,
    note: str = "",
    security: LinkSecurity = ON_THIS_HOST,
) -> str:
    """Ask the sites at these endpoints for an operator; return the reply, TransportError when neither takes it."""
    name = check_cell_name(operator, "operator")
    with link_to(cell, remote_at(remote), local_at(local), security=security) as link:
        ask_remote = RequestClient(link, cell, RemoteClock(link, cell), operator=name)
        ask_local = RequestClient(link, cell, operator=name, patience_ns=LOCAL_PATIENCE_NS)
        reply = RecordClient(ask_remote, ask_local).ask(action, task, outcome, note)
        if reply.code == SILENT:
            raise SilenceError(f"cell {cell}")
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason
