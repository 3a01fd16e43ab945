"""Asks the remote site, as the lease's holder, to record, and to bound and label episodes."""

from functools import partial

from common.errors import TransportError
from common.link.channels import RECORD, check_cell_name
from common.link.config import ON_THIS_HOST, LinkSecurity
from common.link.remote_clock import RemoteClock
from common.link.request_client import RequestClient
from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction, RecordRequest
from farhand.authority.asking import link_to


def request_record(
    cell: str,
    endpoint: str,
    operator: str,
    action: RecordAction,
    task: str = "",
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN,
    note: str = "",
    security: LinkSecurity = ON_THIS_HOST,
) -> str:
    """The remote site's reply to an operator; TransportError when it refuses."""
    name = check_cell_name(operator, "operator")
    make = partial(RecordRequest, action=action, task=task, outcome=outcome, note=note)
    with link_to(cell, endpoint, security) as link:
        reply = RequestClient(link, cell, RemoteClock(link, cell), operator=name).ask(RECORD, make)
    if not reply.done:
        raise TransportError(f"refused ({reply.code}): {reply.reason}")
    return reply.reason
