"""What must happen once although it is asked again and again: a repeated request gets the first answer; pure."""

from collections.abc import Callable
from typing import Generic, TypeVar

from common.clock import NS_PER_S
from common.messages.requests import Reply, Request

Requested = TypeVar("Requested", bound=Request)
Replied = TypeVar("Replied", bound=Reply)

MAX_DEADLINE_NS = 10 * NS_PER_S  # a request is remembered so long that no repetition can outlive it


class Server(Generic[Requested, Replied]):
    """Answers one procedure when polled; a repeated id gets the first answer, an expired one is refused."""

    def __init__(self, poll: Callable[[Callable[[Requested], Replied]], None], reply: type[Replied]) -> None:
        """`poll` answers one waiting request with what it is given, if there is one."""
        self._poll = poll
        self._reply = reply
        self._done: dict[int, tuple[int, Replied]] = {}

    def poll(self, now_ns: int, handle: Callable[[Requested], Replied]) -> None:
        """Answer one waiting request, if there is one; never blocks."""
        self._poll(lambda request: self._answer(request, now_ns, handle))

    def _answer(self, request: Requested, now_ns: int, handle: Callable[[Requested], Replied]) -> Replied:
        known = self._done.get(request.id)
        if known is not None:
            return known[1]
        if now_ns > request.deadline_ns:
            return self._refuse(request, "expired", "the request came after its deadline; ask again")
        if request.deadline_ns - now_ns > MAX_DEADLINE_NS:
            return self._refuse(request, "deadline", "the deadline is too far ahead: the clocks disagree; ask again")
        self._done = {known: kept for known, kept in self._done.items() if kept[0] >= now_ns}
        reply = handle(request)
        self._done[request.id] = (request.deadline_ns, reply)
        return reply

    def _refuse(self, request: Requested, code: str, reason: str) -> Replied:
        return self._reply(id=request.id, done=False, code=code, reason=reason)
