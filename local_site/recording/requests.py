"""Which requests to record the operator's side the local site grants, and why it refuses the others; pure."""

from common.messages.recording import RecordingState
from common.messages.requests import NO_RECORDER, RecordAction, RecordRequest, Reply
from common.recording.episodes import MOST_EPISODES

WHOLE_RECORDING = (RecordAction.START, RecordAction.STOP)
Refusal = tuple[str, str]


def answer(request: RecordRequest, recorder: RecordingState | None, *, holds_lease: bool) -> Reply:
    """The reply to a request; `recorder` is what this host's recorder does, None while none is there."""
    refusal = refusal_of(request.action, recorder, holds_lease=holds_lease)
    code, reason = refusal or ("record_asked", "this host's recorder has been asked")
    return Reply(id=request.id, done=refusal is None, code=code, reason=reason)


def refusal_of(action: RecordAction, recorder: RecordingState | None, *, holds_lease: bool) -> Refusal | None:
    """Code and sentence of a refusal, None where the request is granted; who is recorded may always end that."""
    if recorder is None:
        return NO_RECORDER, "no recorder runs on this host; start one: systemctl start farhand-record-local"
    if action in WHOLE_RECORDING and not recorder.on_request:
        return "record_fixed", "this host's administrator begins and ends the recording (record.start = 'at_once')"
    if action is not RecordAction.STOP and not holds_lease:
        return "no_lease", "this host's operator does not hold the lease: take it first"
    return _episode_refusal(action, recorder) if action not in WHOLE_RECORDING else None


def _episode_refusal(action: RecordAction, recorder: RecordingState) -> Refusal | None:
    if not recorder.writing:
        return "not_recording", "nothing is recorded here now: begin a recording first"
    if action is RecordAction.BEGIN and recorder.episode >= MOST_EPISODES:
        too_many = f"this recording has {MOST_EPISODES} episodes, as many as one may have: have it ended"
        return "too_many_episodes", f"{too_many}, and another begun"
    return None
