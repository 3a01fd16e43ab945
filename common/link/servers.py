"""Polled servers of procedures: questions may be asked again, requests are carried out once."""

from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import zenoh

from common.clock import NS_PER_S
from common.errors import MessageError
from common.link.channels import Procedure
from common.link.tap import MessageTap, untapped
from common.messages.base import Message
from common.messages.codec import decode, encode
from common.messages.requests import Reply, Request

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
Requested = TypeVar("Requested", bound=Request)
Replied = TypeVar("Replied", bound=Reply)
OnRefused = Callable[[MessageError], None]

REFUSAL = b"refused: "  # prefix of our own error replies: Zenoh sends others, for example on a time-out
LEAST_KEPT = 64  # replies; looking through all at each would be work that whoever asks a lot makes for control
MAX_DEADLINE_AHEAD_NS = 10 * NS_PER_S  # bounds how long a reply is kept for repetitions of its request


class Asked(NamedTuple, Generic[Q, R]):
    """A question that waits, the operator whose key it came on (empty where keys name none), and what answers it."""

    operator: str
    question: Q
    reply: Callable[[R], None]


class QuestionServer(Generic[Q, R]):
    """Answers questions that may be asked again; a query that cannot be decoded gets an error reply with the reason."""

    def __init__(
        self,
        queryable: "zenoh.Queryable[zenoh.handlers.Handler[zenoh.Query]]",
        key: str,
        procedure: Procedure[Q, R],
        on_refused: OnRefused,
        tap: MessageTap = untapped,
    ) -> None:
        """`on_refused` is called with the error of every query that cannot be decoded."""
        self._queryable = queryable
        self._key = key
        self._procedure = procedure
        self._on_refused, self._tap = on_refused, tap

    def take(self) -> Asked[Q, R] | None:
        """A waiting question, None if none waits; never blocks."""
        query = self._queryable.try_recv()
        if query is None:
            return None
        key = str(query.key_expr) if self._procedure.by_operator else self._key
        try:
            operator = self._procedure.operator_in(key)
            payload = query.payload.to_bytes() if query.payload is not None else b""
            self._tap(key, payload, sent=False)
            question = decode(payload, self._procedure.request, self._procedure.max_bytes)
        except MessageError as error:
            self._on_refused(error)
            with query:
                query.reply_err(REFUSAL + str(error).encode(errors="replace"))
            return None

        def reply(answer: R) -> None:
            answered = encode(answer)
            with query:
                query.reply(key, answered)
            self._tap(key, answered, sent=True)

        return Asked(operator, question, reply)

    def poll(self, answer: Callable[[Q], R]) -> None:
        """Answer one waiting question, if there is one; never blocks."""
        waiting = self.take()
        if waiting is not None:
            waiting.reply(answer(waiting.question))


class IdempotentServer(Generic[Requested, Replied]):
    """Hands out each request once: a repeated id gets the first reply, an expired request is refused.

    Times are in ns of this host's monotonic clock.
    """

    def __init__(self, server: QuestionServer[Requested, Replied], reply: type[Replied]) -> None:
        self._server = server
        self._reply = reply
        self._done: dict[tuple[str, int], tuple[int, Replied]] = {}  # operator, request id: deadline in ns, reply
        self._forget_at = LEAST_KEPT

    def take(self, now_ns: int) -> Asked[Requested, Replied] | None:
        """A request to carry out, None if none waits; never blocks."""
        waiting = self._server.take()
        if waiting is None:
            return None
        operator, request, answer = waiting
        earlier = self._done.get((operator, request.id))
        known_reply = earlier[1] if earlier is not None else self._refusal(request, now_ns)
        if known_reply is not None:
            answer(known_reply)
            return None

        def reply(done: Replied) -> None:
            self._done[operator, request.id] = (request.deadline_ns, done)
            if len(self._done) >= self._forget_at:
                self._done = {key: kept for key, kept in self._done.items() if kept[0] >= now_ns}
                self._forget_at = max(LEAST_KEPT, 2 * len(self._done))
            answer(done)

        return Asked(operator, request, reply)

    def poll(self, now_ns: int, handle: Callable[[Requested], Replied]) -> None:
        """Carry out and answer one waiting request, if there is one; never blocks."""
        waiting = self.take(now_ns)
        if waiting is not None:
            waiting.reply(handle(waiting.question))

    def _refusal(self, request: Requested, now_ns: int) -> Replied | None:
        if now_ns > request.deadline_ns:
            return self._refuse(request, "expired", "the request came after its deadline; ask again")
        if request.deadline_ns - now_ns > MAX_DEADLINE_AHEAD_NS:
            return self._refuse(request, "deadline", "the deadline is too far ahead: the clocks disagree; ask again")
        return None

    def _refuse(self, request: Requested, code: str, reason: str) -> Replied:
        return self._reply(id=request.id, done=False, code=code, reason=reason)
