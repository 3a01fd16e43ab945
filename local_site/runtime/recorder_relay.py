"""Between this host's recorder and the rest: what it does goes to the console, what the operator may ask goes to it."""

from functools import partial
from typing import Protocol

import structlog

from common.errors import MessageError
from common.link.channels import RECORD_ORDER, RECORD_OWN, RECORDER, RECORDING
from common.link.transport import Link
from common.messages.recording import RecordingState
from common.messages.requests import RecordAction, RecordRequest, Reply
from common.process.log import RefusalLog
from common.recording.episodes import MOST_EPISODES
from common.recording.policy import RecorderRefusal, recorder_refusal
from local_site.authority.lease_client import LeaseAndClock
from local_site.config import LocalConfig

SENTENCES = {
    RecorderRefusal.NO_RECORDER: "no recorder runs on this host; start one: systemctl start farhand-record-local",
    RecorderRefusal.RECORD_FIXED: "this host's administrator begins and ends the recording (record.start = 'at_once')",
    RecorderRefusal.NOT_RECORDING: "nothing is recorded here now: begin a recording first",
    RecorderRefusal.TOO_MANY_EPISODES: f"this recording has {MOST_EPISODES} episodes, as many as one may have: have it "
    "ended, and another begun",
}
NO_LEASE = "no_lease", "this host's operator does not hold the lease: take it first"


class Standing(Protocol):
    """The standing of this site: whether it holds the lease."""

    def lease_and_clock(self, now_ns: int) -> LeaseAndClock: ...


class RecorderRelay:
    """Passes on what recorder and console say: programs connected here do not hear one another."""

    def __init__(self, config: LocalConfig, link: Link, authority: Standing) -> None:
        cell, name = config.cell, config.authority.name
        self._told = link.latest(RECORDER, cell, operator=name)
        self._console = link.publisher(RECORDING, cell, operator=name)
        self._asked = link.serve(RECORD_OWN, cell, RefusalLog().note, operator=name)
        self._orders = link.publisher(RECORD_ORDER, cell, operator=name)
        self._refusals = RefusalLog("recorder's notice refused")
        self._authority = authority
        self._state: RecordingState | None = None
        self._state_ns = 0

    def poll(self, now_ns: int) -> None:
        """Pass on what waits, and answer a request, if there is one."""
        try:
            notice = self._told.take()
        except MessageError as error:
            self._refusals.note(error)
            notice = None
        if notice is not None:
            self._state, self._state_ns = notice.state, now_ns
            self._console.put(notice)
        self._asked.poll(now_ns, partial(self._answer, now_ns))

    def _answer(self, now_ns: int, request: RecordRequest) -> Reply:
        is_there = now_ns - self._state_ns <= RECORDER.stale_after_ns
        lease = self._authority.lease_and_clock(now_ns).lease
        reply = answer(request, self._state if is_there else None, holds_lease=lease != 0)
        if reply.done:
            self._orders.put(request)
            structlog.get_logger().info("recorder asked", action=request.action.value)
        return reply


def answer(request: RecordRequest, recorder: RecordingState | None, *, holds_lease: bool) -> Reply:
    """The reply to a request; `recorder` is what this host's recorder does, None while none is there.

    Who is recorded may always end that.
    """
    refusal = recorder_refusal(request.action, recorder)
    may = request.action is RecordAction.STOP or holds_lease
    if refusal in (RecorderRefusal.NO_RECORDER, RecorderRefusal.RECORD_FIXED) or (refusal and may):
        return Reply(id=request.id, done=False, code=refusal.value, reason=SENTENCES[refusal])
    if not may:
        return Reply(id=request.id, done=False, code=NO_LEASE[0], reason=NO_LEASE[1])
    return Reply(id=request.id, done=True, code="record_asked", reason="this host's recorder has been asked")
