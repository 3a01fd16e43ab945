"""Rules of what a recorder may be asked, whoever asks: the same at both sites; pure."""

from enum import StrEnum

from common.messages.recording import RecordingState
from common.messages.requests import NO_RECORDER, RecordAction
from common.recording.episodes import MOST_EPISODES

WHOLE_RECORDING = (RecordAction.START, RecordAction.STOP)


class RecorderRefusal(StrEnum):
    """Why a recorder cannot do what it is asked, by the code of the reply."""

    NO_RECORDER = NO_RECORDER
    RECORD_FIXED = "record_fixed"
    NOT_RECORDING = "not_recording"
    TOO_MANY_EPISODES = "too_many_episodes"


def recorder_refusal(action: RecordAction, recorder: RecordingState | None) -> RecorderRefusal | None:
    """Why the recorder cannot do this, None where it can; `recorder` is what it does, None while none is there."""
    if recorder is None:
        return RecorderRefusal.NO_RECORDER
    if action in WHOLE_RECORDING:
        return None if recorder.on_request else RecorderRefusal.RECORD_FIXED
    if not recorder.writing:
        return RecorderRefusal.NOT_RECORDING
    is_full = action is RecordAction.BEGIN and recorder.episode >= MOST_EPISODES
    return RecorderRefusal.TOO_MANY_EPISODES if is_full else None
