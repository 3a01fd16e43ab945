"""What the operator asks of the sites through the page: every request once, until it is answered or given up."""

import secrets
import time
from typing import TypeVar

from common.clock import NS_PER_S
from common.errors import TransportError
from common.link.channels import (
    ENGAGEMENT,
    JOINTS,
    OPERATE,
    Procedure,
)
from common.link.transport import Link
from common.messages.requests import (
    EngagementAction,
    EngagementRequest,
    JointsRequest,
    OperatorAction,
    OperatorRequest,
    PictureShare,
    Reply,
    Request,
)
from local_site.console.cell_watch import CellWatch

Asked = TypeVar("Asked", bound=Request)

PATIENCE_NS = 3 * NS_PER_S
SETTLE_S = 0.3
AWAKE_AGAIN = "activated"
REQUEST_BITS = 62


class Acts:
    """Asks and waits, so call it from a thread that may wait; a site that is silent gives a refusal with a sentence."""

    def __init__(self, link: Link, watch: CellWatch, cell: str, operator: str) -> None:
        self._link, self._watch, self._cell, self._operator = link, watch, cell, operator

    def engagement(self, action: EngagementAction) -> Reply:
        """What the remote site answers; a robot that had to be woken is asked a second time."""
        reply = self._ask(action)
        if reply.code == AWAKE_AGAIN:
            time.sleep(SETTLE_S)
            reply = self._ask(action)
        return reply

    def lease(self, action: OperatorAction) -> Reply:
        """What the local site answers."""
        number, give_up_ns = _once()
        return self._ask_local(OPERATE, OperatorRequest(id=number, deadline_ns=give_up_ns, action=action))

    def joints(self, shoulder: PictureShare, elbow: PictureShare, wrist: PictureShare) -> Reply:
        """What the local site answers to where the joints are said to be."""
        number, give_up_ns = _once()
        request = JointsRequest(id=number, deadline_ns=give_up_ns, shoulder=shoulder, elbow=elbow, wrist=wrist)
        return self._ask_local(JOINTS, request)

    def _ask_local(self, procedure: Procedure[Asked, Reply], request: Asked) -> Reply:
        try:
            return self._link.request(procedure, self._cell, request, request.deadline_ns, self._operator)
        except TransportError as error:
            return _silence(request.id, error)

    def _ask(self, action: EngagementAction) -> Reply:
        number, give_up_ns = _once()
        try:
            request = EngagementRequest(
                id=number, deadline_ns=give_up_ns + self._offset_ns(), operator=self._operator, action=action
            )
            return self._link.request(ENGAGEMENT, self._cell, request, give_up_ns)
        except TransportError as error:
            return _silence(number, error)

    def _offset_ns(self) -> int:
        known = self._watch.estimate(time.monotonic_ns()) or self._watch.ask_now()
        if known is None:
            raise TransportError("the remote site does not answer")
        return known.offset.offset_ns


def _once() -> tuple[int, int]:
    """The number of a new request, and when it is given up, ns."""
    return secrets.randbits(REQUEST_BITS), time.monotonic_ns() + PATIENCE_NS


def _silence(number: int, error: TransportError) -> Reply:
    return Reply(id=number, done=False, code="silent", reason=str(error)[:400])
