"""Asks the remote site, as operator or maintenance, to stop the arm or for anything else of the engagement."""

import threading
from functools import partial

from common.link.channels import ENGAGEMENT, MAINTENANCE, MAINTENANCE_STOP, STOP
from common.link.request_client import RequestClient
from common.messages.requests import EngagementAction, EngagementRequest, Reply


def ask_engagement(
    client: RequestClient,
    action: EngagementAction,
    seen_ns: int = 0,
    *,
    maintenance: bool = False,
    withdrawn: threading.Event | None = None,
) -> Reply:
    """The remote site's reply to the client's operator, or to `maintenance`; errors as `RequestClient.ask`.

    `seen_ns` is the newest halt that whoever resets or engages was shown (`RobotState.halted_ns`).
    """
    if action is EngagementAction.STOP:
        return client.stop(MAINTENANCE_STOP if maintenance else STOP)
    make = partial(EngagementRequest, action=action, seen_ns=seen_ns)
    return client.ask(MAINTENANCE if maintenance else ENGAGEMENT, make, withdrawn)
