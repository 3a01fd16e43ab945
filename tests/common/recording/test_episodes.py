"""Episodes: what begins and ends them, and what is known of them in the end."""

from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction
from common.recording.config import EpisodeBounds
from common.recording.episodes import MOST_EPISODES, EpisodeEvent, Episodes
from common.recording.recorded_episodes import episodes_of

UNKNOWN, SUCCESS, FAILURE = EpisodeOutcome
NOTHING = "", UNKNOWN, ""


def told(events: list[EpisodeEvent]) -> list[tuple[str, int, str]]:
    return [(event.event.value, event.episode, event.by) for event in events]


def test_an_engagement_is_an_episode_and_a_hold_is_part_of_it() -> None:
    episodes = Episodes(EpisodeBounds.ENGAGEMENT, "push")
    assert told(episodes.follow(engaged=True, t_ns=1)) == [("begin", 1, "engagement")]
    assert episodes.follow(engaged=True, t_ns=2) == []
    assert told(episodes.follow(engaged=False, t_ns=3)) == [("end", 1, "engagement")]
    assert told(episodes.follow(engaged=True, t_ns=4)) == [("begin", 2, "engagement")]


def test_a_request_within_an_engagement_parts_it() -> None:
    episodes = Episodes(EpisodeBounds.ENGAGEMENT)
    episodes.follow(engaged=True, t_ns=1)
    assert told(episodes.act(RecordAction.BEGIN, "anna", 2, *NOTHING)) == [("end", 1, "anna"), ("begin", 2, "anna")]
    assert told(episodes.act(RecordAction.END, "anna", 3, *NOTHING)) == [("end", 2, "anna")]
    assert episodes.follow(engaged=False, t_ns=4) == []


def test_an_episode_begun_by_request_outlasts_no_engagement_but_waits_for_none() -> None:
    episodes = Episodes(EpisodeBounds.ENGAGEMENT)
    episodes.act(RecordAction.BEGIN, "anna", 1, *NOTHING)
    assert episodes.follow(engaged=True, t_ns=2) == []
    assert told(episodes.follow(engaged=False, t_ns=3)) == [("end", 1, "engagement")]


def test_no_recording_gets_more_episodes_than_a_reader_takes() -> None:
    asked, followed = Episodes(EpisodeBounds.REQUESTS), Episodes(EpisodeBounds.ENGAGEMENT)
    events: list[EpisodeEvent] = []
    for t_ns in range(2 * MOST_EPISODES + 4):
        events += asked.act(RecordAction.BEGIN, "anna", t_ns, *NOTHING)
        followed.follow(engaged=t_ns % 2 == 0, t_ns=t_ns)
    assert len(episodes_of(events)) == MOST_EPISODES
    assert asked.is_open
    assert (followed.number, followed.is_open) == (MOST_EPISODES, False)
    assert told(asked.act(RecordAction.END, "anna", 10**6, *NOTHING)) == [("end", MOST_EPISODES, "anna")]


def test_a_label_is_of_the_last_episode_and_only_a_change_is_an_event() -> None:
    episodes = Episodes(EpisodeBounds.ENGAGEMENT)
    assert episodes.act(RecordAction.LABEL, "anna", 1, "", SUCCESS, "") == []
    episodes.follow(engaged=True, t_ns=2)
    episodes.follow(engaged=False, t_ns=3)
    (event,) = episodes.act(RecordAction.LABEL, "anna", 4, "", SUCCESS, "clean")
    assert (event.episode, event.outcome, event.note) == (1, SUCCESS, "clean")
    assert episodes.act(RecordAction.LABEL, "anna", 5, "", SUCCESS, "") == []
    (event,) = episodes.act(RecordAction.LABEL, "anna", 6, "", FAILURE, "")
    assert (event.outcome, event.note) == (FAILURE, "clean")
    (event,) = episodes.follow(engaged=True, t_ns=7)
    assert (event.outcome, event.note) == (UNKNOWN, "")


def test_a_task_stays_until_another_is_given() -> None:
    episodes = Episodes(EpisodeBounds.REQUESTS, "push")
    (event,) = episodes.act(RecordAction.BEGIN, "anna", 1, *NOTHING)
    assert event.task == "push"
    (event,) = episodes.act(RecordAction.LABEL, "anna", 2, "pull", UNKNOWN, "")
    assert event.task == "pull"
    *_, event = episodes.act(RecordAction.BEGIN, "anna", 3, *NOTHING)
    assert event.task == "pull"


def test_an_end_without_an_episode_is_nothing_and_a_recordings_end_ends_it() -> None:
    episodes = Episodes(EpisodeBounds.REQUESTS)
    assert episodes.act(RecordAction.END, "anna", 1, *NOTHING) == []
    assert episodes.finish(2) == []
    episodes.act(RecordAction.BEGIN, "anna", 3, *NOTHING)
    assert told(episodes.finish(4)) == [("end", 1, "recording")]
