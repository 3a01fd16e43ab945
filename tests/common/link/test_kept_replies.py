"""Replies are kept for repetitions of their request, and no longer; whoever asks a lot makes no work for control."""

from collections.abc import Callable

import msgspec

from common.clock import NS_PER_S
from common.link.servers import LEAST_KEPT, Asked, IdempotentServer
from common.messages.requests import EngagementAction, EngagementRequest, Reply


class _Waiting:
    """Requests that wait, and the answers that they got."""

    def __init__(self) -> None:
        self.requests: list[EngagementRequest] = []
        self.answers: list[Reply] = []

    def take(self) -> Asked[EngagementRequest, Reply] | None:
        return Asked("anna", self.requests.pop(0), self.answers.append) if self.requests else None


def asked(number: int, deadline_ns: int) -> EngagementRequest:
    return EngagementRequest(id=number, deadline_ns=deadline_ns, action=EngagementAction.ENGAGE)


def carried_out(number: int) -> Callable[[EngagementRequest], Reply]:
    return lambda request: Reply(id=request.id, done=True, code="ok", reason=str(number))


def test_a_repeated_request_gets_its_first_reply_and_old_replies_go() -> None:
    waiting = _Waiting()
    server = IdempotentServer[EngagementRequest, Reply](waiting, Reply)  # type: ignore[arg-type]
    now_ns, most = 0, 0
    for number in range(10_000):
        now_ns += NS_PER_S // 100
        waiting.requests.append(asked(number, now_ns + NS_PER_S))
        server.poll(now_ns, carried_out(number))
        most = max(most, len(server._done))
    assert most <= 4 * LEAST_KEPT
    waiting.requests.append(asked(9_990, now_ns + NS_PER_S))
    server.poll(now_ns, carried_out(-1))
    assert waiting.answers[-1].reason == "9990"
    assert msgspec.structs.replace(waiting.answers[-1], reason="") == Reply(id=9_990, done=True, code="ok", reason="")
