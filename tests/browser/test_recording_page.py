"""The page says whenever something is recorded, with whose pictures, and asks the recorder by its keys."""

from collections.abc import Callable
from functools import partial

import msgspec
import pytest

from common.messages.recording import EpisodeOutcome, RecordingNotice, RecordingState
from common.messages.requests import RecordAction
from local_site.console.hub import Hub
from tests.browser.told import Told

RECORDING = RecordingState(
    writing=True,
    on_request=False,
    operator_pictures=False,
    episode=2,
    episode_open=True,
    task="put the block on the mark",
    outcome=EpisodeOutcome.UNKNOWN,
    lost=0,
    alarm="",
    seconds=754.2,
    size_bytes=1_234_567_890,
    episode_seconds=41.9,
)
REC, CLOCKS = "REC 12:34 · 1.2 GB", "episode 2 0:41"
HIDDEN = "(id) => document.getElementById(id).hidden"


def tell(told: Told, **changes: object) -> None:
    told.state = partial(told.state, recording=msgspec.structs.replace(RECORDING, **changes))


def hidden(told: Told, name: str) -> bool:
    return bool(told.page.page.evaluate(HIDDEN, name))


def test_without_a_recorder_the_page_shows_nothing_of_it(told: Told) -> None:
    told.until("no mark", lambda: hidden(told, "recording") and hidden(told, "recording-row"))


def test_a_mark_shows_whenever_something_is_recorded_and_with_whose_pictures(told: Told) -> None:
    tell(told)
    told.until(
        "the mark", lambda: not hidden(told, "recording") and told.page.words("#recording") == f"{REC} · {CLOCKS}"
    )
    words = "episode 2 · 0:41 · put the block on the mark"
    told.until("the episode", lambda: told.page.words("#episode-words") == words)
    told.shot("recording")
    tell(told, operator_pictures=True, lost=3)
    loud = f"REC, with the operator's pictures 12:34 · 1.2 GB · {CLOCKS} · 3 lost"
    told.until("the operator's pictures", lambda: told.page.words("#recording") == loud)
    tell(told, writing=False)
    told.until("no mark", lambda: hidden(told, "recording"))


@pytest.mark.slow
def test_a_recorder_of_the_operators_own_side_is_marked_too(told: Told) -> None:
    own = RecordingNotice(state=msgspec.structs.replace(RECORDING, operator_pictures=True))
    told.give(Hub.recording, own)
    told.until("the mark", lambda: told.page.words("#recording").startswith("REC, with the operator's pictures 12:34"))
    told.until("its end", lambda: hidden(told, "recording") and hidden(told, "recording-row"))  # it tells nothing more


@pytest.mark.slow
def test_the_holder_begins_and_ends_the_recording_of_their_own_side(told: Told) -> None:
    own = partial(msgspec.structs.replace, RECORDING, operator_pictures=True, on_request=True, episode=0)

    def told_of_own(**changes: object) -> Callable[[], bool]:
        words = changes.pop("words")

        def is_so() -> bool:
            told.give(Hub.recording, RecordingNotice(state=own(**changes)))
            return not hidden(told, "record") and told.page.words("#record") == words

        return is_so

    for writing, words, action in ((False, "Record", RecordAction.START), (True, "End recording", RecordAction.STOP)):
        told.until("the button", told_of_own(writing=writing, words=words))
        assert hidden(told, "recording") is not writing
        begin = len(told.sites.recorded)
        told.page.page.click("#record")
        told.until("the request", lambda: len(told.sites.recorded) > begin)  # noqa: B023  # called in this round
        assert told.sites.recorded[begin:] == [(action, EpisodeOutcome.UNKNOWN)]
    tell(told)  # the cell's recorder runs at once, and its episodes are the ones that are shown
    told.until("both", told_of_own(writing=True, words="End recording"))
    told.until("its episode", lambda: told.page.words("#episode-words").startswith("episode 2 ·"))


def test_a_recording_that_ended_by_itself_raises_an_alarm(told: Told) -> None:
    tell(told, writing=False, alarm="recording has ended: No space left on device")
    told.until("the alarm", lambda: told.page.words("#alert") == "recording has ended: No space left on device")
    tell(told)
    told.until("no alarm", lambda: hidden(told, "alert"))


def test_keys_bound_and_label_episodes(told: Told) -> None:
    tell(told)
    told.until("the row", lambda: not hidden(told, "recording-row"))
    keyboard, asked = told.page.page.keyboard, told.sites.recorded
    begin = len(asked)
    for key in "sfp":
        keyboard.press(key)
    told.until("the requests", lambda: len(asked) == begin + 3)
    tell(told, episode_open=False)
    told.until("its end", lambda: told.page.words("#episode-words").startswith("episode 2 has ended"))
    keyboard.press("p")
    told.until("the next", lambda: len(asked) == begin + 4)
    assert asked[begin:] == [
        (RecordAction.LABEL, EpisodeOutcome.SUCCESS),
        (RecordAction.LABEL, EpisodeOutcome.FAILURE),
        (RecordAction.END, EpisodeOutcome.UNKNOWN),
        (RecordAction.BEGIN, EpisodeOutcome.UNKNOWN),
    ]


@pytest.mark.slow
def test_the_holder_begins_and_ends_a_recording_only_where_that_is_allowed(told: Told) -> None:
    tell(told)
    told.until("no button", lambda: not hidden(told, "recording-row") and hidden(told, "record"))
    tell(told, on_request=True, writing=False)
    told.until("the button", lambda: not hidden(told, "record"))
    begin = len(told.sites.recorded)
    told.page.page.keyboard.press("p")  # of what is not recorded there are no episodes
    told.page.page.click("#record")
    told.until("the request", lambda: len(told.sites.recorded) > begin)
    assert told.sites.recorded[begin:] == [(RecordAction.START, EpisodeOutcome.UNKNOWN)]
