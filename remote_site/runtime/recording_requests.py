"""Answers the requests to record: the lease's holder may ask, and the recorder of this host carries them out."""

from collections.abc import Callable, Sequence

from common.errors import MessageError
from common.link.channels import RECORD
from common.link.transport import Link
from common.messages.recording import RecordingState
from common.messages.requests import RecordAction, RecordRequest, Reply
from common.recording.episodes import MOST_EPISODES
from common.recording.policy import RecorderRefusal, recorder_refusal
from remote_site.reasons import Code, Reason, reason
from remote_site.recording.records import RecordOrder
from remote_site.recording.taps import ControlTap
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.session.lease import Lease, LeaseServer

REFUSALS = {
    RecorderRefusal.NO_RECORDER: reason(Code.NO_RECORDER),
    RecorderRefusal.RECORD_FIXED: reason(Code.RECORD_FIXED),
    RecorderRefusal.NOT_RECORDING: reason(Code.NOT_RECORDING),
    RecorderRefusal.TOO_MANY_EPISODES: reason(Code.TOO_MANY_EPISODES, most=MOST_EPISODES),
}


class RecordingRequests:
    """Polled by the control loop after each command is written; the recorder's next state shows what came of it."""

    def __init__(
        self,
        link: Link,
        cell: str,
        operators: Sequence[str],
        leases: LeaseServer,
        tap: ControlTap,
        refused: Callable[[MessageError], None],
    ) -> None:
        self._servers = [link.serve(RECORD, cell, refused, operator=operator) for operator in operators]
        self._leases, self._tap = leases, tap

    def poll(self, now_ns: int) -> None:
        """Answer one waiting request of each operator."""
        for server in self._servers:
            if (asked := server.take(now_ns)) is not None:
                asked.reply(self._answer(asked.question, asked.operator, now_ns))

    def _answer(self, request: RecordRequest, operator: str, now_ns: int) -> Reply:
        refusal = refusal_of(request.action, operator, self._leases.current(now_ns), self._tap.state(now_ns))
        if refusal is None:
            self._tap.order(RecordOrder(request.action, operator, request.task, request.outcome, request.note))
        answer = refusal or reason(Code.RECORD_ASKED)
        return Reply(id=request.id, done=refusal is None, code=answer.code.value, reason=answer.sentence)


class ControlRecording:
    """Control's work for a recorder in each tick, behind its command."""

    def __init__(self, tap: ControlTap, requests: RecordingRequests) -> None:
        self._tap, self._requests = tap, requests

    def tick(self, driven: DrivenPipeline) -> None:
        """Keep the cycle that has just been carried out, and answer a request."""
        if driven.given is not None and driven.command is not None:
            self._tap.note_cycle(driven.given, driven.command, driven.ordered, driven.report)
            self._requests.poll(driven.given.now_ns)


def refusal_of(
    action: RecordAction, operator: str, lease: Lease | None, recorder: RecordingState | None
) -> Reason | None:
    """Say why this operator's request is not carried out, None where it is; without a recorder `recorder` is None."""
    if lease is None:
        return reason(Code.NO_LEASE)
    if lease.holder.name != operator:
        return reason(Code.NOT_HOLDER, holder=lease.holder)
    refusal = recorder_refusal(action, recorder)
    return REFUSALS[refusal] if refusal is not None else None
