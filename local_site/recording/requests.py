"""Requests to record the operator's side: which the local site grants, and why it refuses the others; pure."""

from common.messages.recording import RecordingState
from common.messages.requests import RecordAction, RecordRequest, Reply
from common.recording.episodes import MOST_EPISODES
from common.recording.policy import RecorderRefusal, recorder_refusal

SENTENCES = {
    RecorderRefusal.NO_RECORDER: "no recorder runs on this host; start one: systemctl start farhand-record-local",
    RecorderRefusal.RECORD_FIXED: "this host's administrator begins and ends the recording (record.start = 'at_once')",
    RecorderRefusal.NOT_RECORDING: "nothing is recorded here now: begin a recording first",
    RecorderRefusal.TOO_MANY_EPISODES: f"this recording has {MOST_EPISODES} episodes, as many as one may have: have it "
    "ended, and another begun",
}
NO_LEASE = "no_lease", "this host's operator does not hold the lease: take it first"


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
