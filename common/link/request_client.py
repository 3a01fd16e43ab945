"""Requests that must take effect once: resent under the same id until they are answered or their deadline is over."""

import secrets
import threading
from collections.abc import Callable
from typing import Protocol, TypeVar

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import SilenceError, TransportError
from common.host_clock import MonotonicClock
from common.link.channels import ANY, Procedure
from common.link.remote_clock import RemoteClock
from common.link.transport import REQUEST_TIMEOUT_S, Link
from common.messages.base import Message
from common.messages.requests import SILENT, Reply, Request, StopRequest

Question = TypeVar("Question", bound=Message)
Requested = TypeVar("Requested", bound=Request)
Requested_co = TypeVar("Requested_co", bound=Request, covariant=True)
Replied = TypeVar("Replied", bound=Reply)

PATIENCE_NS = 3 * NS_PER_S
ATTEMPT_NS = 300 * NS_PER_MS
ID_BITS = 62
WITHDRAWN = "not sent any more: a stop, or an end of the engagement, was asked for after it"


class RequestMaker(Protocol[Requested_co]):
    """Completes a request with its id and its deadline, by the server's clock."""

    def __call__(self, *, id: int, deadline_ns: int) -> Requested_co: ...  # noqa: A002  # the message's field


class RequestSchedule:
    """The times at which a request is sent, sent again and given up; pure.

    It is sent at `due_ns`, every ATTEMPT_NS under the same `id`, and given up at `give_up_ns`, `patience_ns` after its
    start.
    """

    def __init__(self, number: int, patience_ns: int, now_ns: int) -> None:
        self.id, self.due_ns, self.give_up_ns = number, now_ns, now_ns + patience_ns

    def is_over(self, now_ns: int) -> bool:
        """Return whether the deadline has passed."""
        return now_ns >= self.give_up_ns

    def sent(self, now_ns: int) -> None:
        """The request is being sent."""
        self.due_ns = min(now_ns + ATTEMPT_NS, self.give_up_ns)


def answered(ask: Callable[[], Reply]) -> Reply:
    """The reply that `ask` brings; where it raises a TransportError, a refusal with the code SILENT and its words."""
    try:
        return ask()
    except TransportError as error:
        return Reply(id=0, done=False, code=SILENT, reason=str(error))


class RequestClient:
    """Asks one site of a cell; call it from a thread that may wait.

    `remote_clock` is None where a site of this host is asked: deadlines are by the server's clock. `operator` is
    whose key the procedure is asked on.
    """

    def __init__(
        self,
        link: Link,
        cell: str,
        remote_clock: RemoteClock | None = None,
        *,
        operator: str = ANY,
        patience_ns: int | None = None,
        clock: Clock | None = None,
    ) -> None:
        self._link, self._cell, self._operator = link, cell, operator
        self._remote_clock = remote_clock
        self._patience_ns = PATIENCE_NS if patience_ns is None else patience_ns
        self._clock = clock or MonotonicClock()

    def ask(
        self,
        procedure: Procedure[Requested, Replied],
        make: RequestMaker[Requested],
        withdrawn: threading.Event | None = None,
    ) -> Replied:
        """The reply; TransportError without an answer, RefusedError when the sites do not understand each other.

        Once `withdrawn` is set it is not sent any more: TransportError.
        """

        def request(schedule: RequestSchedule, now_ns: int) -> Requested | None:
            offset_ns = self._offset_ns(now_ns)
            return make(id=schedule.id, deadline_ns=schedule.give_up_ns + offset_ns) if offset_ns is not None else None

        return self._persist(procedure, request, withdrawn)

    def stop(self, procedure: Procedure[StopRequest, Reply]) -> Reply:
        """The reply to a stop, which does not wait until the remote clock is known; errors as `ask`."""
        return self._persist(procedure, lambda _schedule, _now_ns: StopRequest())

    def _persist(
        self,
        procedure: Procedure[Question, Replied],
        make: Callable[[RequestSchedule, int], Question | None],
        withdrawn: threading.Event | None = None,
    ) -> Replied:
        """Ask what `make` gives, None for nothing yet, until it is answered or the time is up."""
        clock = self._clock
        schedule = RequestSchedule(secrets.randbits(ID_BITS), self._patience_ns, clock.now_ns())
        while True:
            clock.sleep_until_ns(schedule.due_ns)
            now_ns = clock.now_ns()
            if schedule.is_over(now_ns):
                raise SilenceError(f"cell {self._whom}")
            schedule.sent(now_ns)
            request = make(schedule, now_ns)
            if withdrawn is not None and withdrawn.is_set():
                raise TransportError(WITHDRAWN)
            if request is None:
                continue
            timeout_s = min(REQUEST_TIMEOUT_S, (schedule.give_up_ns - now_ns) / NS_PER_S)
            reply = self._link.ask(procedure, self._cell, request, operator=self._operator, timeout_s=timeout_s)
            if reply is not None:
                return reply

    @property
    def _whom(self) -> str:
        """The cell, and the operator whose site is asked where the procedure is an operator's own."""
        return self._cell if self._operator == ANY else f"{self._cell} for operator {self._operator}"

    def _offset_ns(self, now_ns: int) -> int | None:
        """The asked site's clock minus ours; None while it is not known."""
        remote = self._remote_clock
        if remote is None:
            return 0
        known = remote.estimate(now_ns)
        if known is None and remote.measure() is not None:
            known = remote.estimate(self._clock.now_ns())
        return None if known is None else known.offset.offset_ns
