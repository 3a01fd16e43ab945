"""Servers of procedures, polled: of questions that may be asked again, and of requests that must take effect once."""

from collections.abc import Callable
from typing import Generic, TypeVar

import zenoh

from common.clock import NS_PER_S
from common.errors import MessageError
from common.link.channels import Procedure
from common.messages.base import Message
from common.messages.codec import decode, encode
from common.messages.requests import Reply, Request

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
Requested = TypeVar("Requested", bound=Request)
Replied = TypeVar("Replied", bound=Reply)
Refused = Callable[[MessageError], None]

REFUSAL = b"refused: "  # begins our own error replies; zenoh has others, such as for a time-out
MAX_DEADLINE_NS = 10 * NS_PER_S  # a request is remembered until its deadline, so that no repetition outlives it


class QuestionServer(Generic[Q, R]):
    """Answers questions that may be asked again; what cannot be understood is refused with a sentence."""

    def __init__(
        self,
        queryable: "zenoh.Queryable[zenoh.handlers.Handler[zenoh.Query]]",
        key: str,
        procedure: Procedure[Q, R],
        refused: Refused,
    ) -> None:
        """`refused` is called for every query that was refused."""
        self._queryable = queryable
        self._key = key
        self._procedure = procedure
        self._refused = refused

    def take(self) -> tuple[Q, Callable[[R], None]] | None:
        """A waiting question and what answers it, None without one; never blocks."""
        query = self._queryable.try_recv()
        if query is None:
            return None
        try:
            payload = query.payload.to_bytes() if query.payload is not None else b""
            question = decode(payload, self._procedure.request, self._procedure.max_bytes)
        except MessageError as error:
            self._refused(error)
            with query:
                query.reply_err(REFUSAL + str(error).encode())
            return None

        def reply(answer: R) -> None:
            with query:
                query.reply(self._key, encode(answer))

        return question, reply

    def poll(self, answer: Callable[[Q], R]) -> None:
        """Answer one waiting question, if there is one; never blocks."""
        waiting = self.take()
        if waiting is not None:
            question, reply = waiting
            reply(answer(question))


class IdempotentServer(Generic[Requested, Replied]):
    """Hands out each request once: a repeated id gets the first reply, an expired request is refused."""

    def __init__(self, server: QuestionServer[Requested, Replied], reply: type[Replied]) -> None:
        self._server = server
        self._reply = reply
        self._done: dict[int, tuple[int, Replied]] = {}

    def take(self, now_ns: int) -> tuple[Requested, Callable[[Replied], None]] | None:
        """A request that waits to be carried out and what answers it, None without one; never blocks."""
        waiting = self._server.take()
        if waiting is None:
            return None
        request, answer = waiting
        known = self._done.get(request.id)
        refusal = known[1] if known is not None else self._refusal(request, now_ns)
        if refusal is not None:
            answer(refusal)
            return None

        def reply(done: Replied) -> None:
            self._done = {number: kept for number, kept in self._done.items() if kept[0] >= now_ns}
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
