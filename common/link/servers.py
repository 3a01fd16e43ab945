"""Servers of procedures, polled: of questions that may be asked again, and of requests that must happen once."""

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
        """`refused` hears of every query that was refused."""
        self._queryable = queryable
        self._key = key
        self._procedure = procedure
        self._refused = refused

    def poll(self, answer: Callable[[Q], R]) -> None:
        """Answer one waiting question, if there is one; never blocks."""
        query = self._queryable.try_recv()
        if query is None:
            return
        with query:
            try:
                payload = query.payload.to_bytes() if query.payload is not None else b""
                question = decode(payload, self._procedure.request, self._procedure.max_bytes)
            except MessageError as error:
                self._refused(error)
                query.reply_err(REFUSAL + str(error).encode())
                return
            query.reply(self._key, encode(answer(question)))


class IdempotentServer(Generic[Requested, Replied]):
    """Handles each request once: a repeated id gets the first reply, an expired request is refused."""

    def __init__(self, server: QuestionServer[Requested, Replied], reply: type[Replied]) -> None:
        self._server = server
        self._reply = reply
        self._done: dict[int, tuple[int, Replied]] = {}

    def poll(self, now_ns: int, handle: Callable[[Requested], Replied]) -> None:
        """Answer one waiting request, if there is one; never blocks."""
        self._server.poll(lambda request: self._answer(request, now_ns, handle))

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
