"""Episodes as a recording has them: put together from their events, over all its files."""

from pathlib import Path

from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction
from common.recording.config import RecordConfig
from common.recording.episodes import EpisodeEvent, EpisodeEventKind
from common.recording.recorded_episodes import RecordedEpisode, episodes_of, read_episodes
from tests.remote_site.driven_loop import CONFIG
from tests.remote_site.recording.recorded_site import RecordedSite

UNKNOWN, FAILURE = EpisodeOutcome.UNKNOWN, EpisodeOutcome.FAILURE


def event(
    kind: EpisodeEventKind, t_ns: int, outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN, episode: int = 1
) -> EpisodeEvent:
    return EpisodeEvent(event=kind, episode=episode, t_ns=t_ns, by="anna", task="stack", outcome=outcome, note="n")


def test_of_several_events_of_an_episode_the_last_holds() -> None:
    begin, end = event(EpisodeEventKind.BEGIN, 10), event(EpisodeEventKind.END, 20)
    label = event(EpisodeEventKind.LABEL, 30, FAILURE)
    assert episodes_of([begin, end, label]) == [RecordedEpisode(1, 10, 20, "stack", FAILURE, "n")]
    assert episodes_of([]) == []


def test_where_no_event_says_when_an_episode_begins_or_ends_nothing_is_made_up() -> None:
    second = event(EpisodeEventKind.BEGIN, 40, episode=2)
    assert episodes_of([event(EpisodeEventKind.END, 20), second]) == [
        RecordedEpisode(1, None, 20, "stack", UNKNOWN, "n"),
        RecordedEpisode(2, 40, None, "stack", UNKNOWN, "n"),
    ]


def test_an_episode_that_a_split_parts_is_one(tmp_path: Path) -> None:
    site = RecordedSite(tmp_path, RecordConfig(split_minutes=0.1))
    site.loop.link.activate(CONFIG.robot.start)
    site.run(0.4)
    site.order(RecordAction.BEGIN, task="wait")
    site.idle(7.0)
    site.order(RecordAction.END, outcome=EpisodeOutcome.SUCCESS)
    site.end()
    first, second = sorted(site.out.iterdir())
    (episode,) = read_episodes([first, second])
    assert (episode.number, episode.task, episode.outcome) == (1, "wait", EpisodeOutcome.SUCCESS)
    assert episode.begin_ns is not None
    assert episode.end_ns is not None
    assert episode.end_ns - episode.begin_ns > 6.9e9
    assert [one.end_ns for one in read_episodes([first])] == [None]
