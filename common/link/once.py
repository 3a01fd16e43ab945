"""What must happen once although it may be asked several times: a repeated request gets the first answer; pure."""

from collections.abc import Callable
from typing import Generic, TypeVar

from common.clock import NS_PER_S
from common.messages.requests import Reply, Request

Requested = TypeVar("Requested", bound=Request)
Replied = TypeVar("Replied", bound=Reply)

MAX_DEADLINE_NS = 10 * NS_PER_S  # a request is remembered so long that no repetition can outlive it


class Server(Generic[Requested, Replied]):
    """Hands out the requests of one procedure; a repeated id gets the first answer, an expired request is refused."""

    def __init__(
        self, take: Callable[[], tuple[Requested, Callable[[Replied], None]] | None], reply: type[Replied]
    ) -> None:
        """`take` returns a waiting request and what answers it, None without one."""
        self._take = take
        self._reply = reply
        self._done: dict[int, tuple[int, Replied]] = {}

    def take(self, now_ns: int) -> tuple[Requested, Callable[[Replied], None]] | None:
        """A request that waits to be carried out and what answers it, None without one; never blocks."""
        waiting = self._take()
        if waiting is None:
            return None
        request, answer = waiting
        known = self._done.get(request.id)
        refusal = known[1] if known is not None else self._refusal(request, now_ns)
        if refusal is not None:
            answer(refusal)
            return None

        def reply(done: Replied) -> None:
            self._done = {id_: kept for id_, kept in self._done.items() if kept[0] >= now_ns}
            self._done[request.id] = (request.deadline_ns, done)
            answer(done)

        return request, reply

    def poll(self, now_ns: int, handle: Callable[[Requested], Replied]) -> None:
        """Carry out and answer one waiting request, if there is one; never blocks."""
        waiting = self.take(now_ns)
        if waiting is not None:
            request, reply = waiting
            reply(handle(request))

    def _refusal(self, request: Requested, now_ns: int) -> Replied | None:
        if now_ns > request.deadline_ns:
            return self._refused(request, "expired", "the request came after its deadline; ask again")
        if request.deadline_ns - now_ns > MAX_DEADLINE_NS:
            return self._refused(request, "deadline", "the deadline is too far ahead: the clocks disagree; ask again")
        return None

    def _refused(self, request: Requested, code: str, reason: str) -> Replied:
        return self._reply(id=request.id, done=False, code=code, reason=reason)
