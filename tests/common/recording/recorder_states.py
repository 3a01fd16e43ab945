"""What a recorder does, as the tests of both sites' grants need it."""

import msgspec

from common.messages.recording import EpisodeOutcome, RecordingState
from common.recording.episodes import MOST_EPISODES


def recorder(*, writing: bool, on_request: bool) -> RecordingState:
    return RecordingState(
        writing=writing,
        on_request=on_request,
        operator_pictures=False,
        episode=0,
        episode_open=False,
        task="",
        outcome=EpisodeOutcome.UNKNOWN,
        lost=0,
        alarm="",
    )


IDLE = recorder(writing=False, on_request=True)
ASKED, FIXED = recorder(writing=True, on_request=True), recorder(writing=True, on_request=False)
FULL = msgspec.structs.replace(ASKED, episode=MOST_EPISODES, episode_open=True)
