"""What the local site makes of the remote's states: whether the arm is engaged, and by this site."""

from types import SimpleNamespace

import pytest
from structlog.testing import capture_logs

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_MS
from common.link.pubsub import Latest
from common.messages.robot import RobotState, SessionState
from local_site.authority.remote_watch import ChannelHealth, RemoteWatch

LEASE = SimpleNamespace(session=7, asked_by=None)


def state(engagement=None, word="engaged", code="following", ready="ok", age_limit_ms=100.0, **links):
    return SimpleNamespace(
        state=SessionState(word),
        code=code,
        reason="",
        lease=LEASE,
        settings=links.get("settings"),
        engagement=engagement,
        age_limit_ms=age_limit_ms,
        speed_scale=100.0 / age_limit_ms,
        timing=SimpleNamespace(late_p99_us=0.0, missed=0, ticks=0),
        hand_link=links.get("hand_link"),
        video_link=links.get("video_link"),
        readiness=SimpleNamespace(code=ready, reason="the link takes 310 ms"),
    )


def state_in(word):
    return state(word=word, code="stale" if word == "holding" else "ok")


class States(Latest[RobotState]):
    """Gives one state after another."""

    def __init__(self, *states):
        self._states = list(states)

    def take(self):
        return self._states.pop(0) if self._states else None


def test_who_waits_is_told_of_the_hands_origin_under_the_own_lease_alone():
    for session, told in ((LEASE.session, [123]), (LEASE.session + 1, [])):
        heard: list[int] = []
        states = States(state(), state(SimpleNamespace(hand_capture_ns=123)))
        watch = RemoteWatch(states, session, heard.append)
        watch.poll(1)
        assert heard == []
        watch.poll(2)
        assert heard == told


def test_reasons_that_come_and_go_are_logged_once_a_second_and_states_at_once():
    flickering = [state(code=code) for code in ("ok", "singular") * 30]
    watch = RemoteWatch(States(*flickering, state(word="holding", code="stale")), LEASE.session, lambda _: None)
    with capture_logs() as logs:
        for k in range(len(flickering)):
            watch.poll(k * 33 * NS_PER_MS)
        assert [line["event"] for line in logs].count("remote") == 2
        watch.poll((len(flickering) + 1) * 33 * NS_PER_MS)
    assert logs[-1]["state"] == "holding"


def test_an_arm_that_holds_and_follows_all_the_time_takes_a_line_a_second_with_the_count():
    words = [("engaged", "holding")[k // 3 % 2] for k in range(91)]
    watch = RemoteWatch(States(*map(state_in, words)), LEASE.session, lambda _: None)
    with capture_logs() as logs:
        for k in range(len(words)):
            watch.poll(k * 33 * NS_PER_MS)
    remote = [line.get("changes", 1) for line in logs if line["event"] == "remote"]
    assert remote == [1, 10, 10]


@pytest.mark.parametrize(
    ("code", "event", "level"),
    [("site_ended", "the remote site has ended", "info"), ("ok", "the remote site is silent", "warning")],
)
def test_the_silence_of_a_site_that_was_asked_to_end_is_no_failure(code, event, level):
    watch = RemoteWatch(States(state(code=code)), LEASE.session, lambda _: None)
    with capture_logs() as logs:
        watch.poll(0)
        watch.poll(501 * NS_PER_MS)
    assert (logs[-1]["event"], logs[-1]["log_level"]) == (event, level)


def test_what_the_remote_site_finds_wrong_with_the_links_is_logged_here_too():
    for session, events in (
        (LEASE.session, ["link of the hand", "link of the pictures"]),
        (LEASE.session + 1, ["link of the pictures"]),  # those are another operator's samples
    ):
        states = States(state(hand_link=golden.STATE.hand_link, video_link=golden.STATE.video_link))
        with capture_logs() as logs:
            RemoteWatch(states, session, lambda _: None).poll(0)
        assert [line["event"] for line in logs if line["log_level"] == "warning"] == events


def test_a_changed_age_limit_and_a_link_that_is_too_slow_are_logged_once() -> None:
    states = [state(), state(age_limit_ms=200.0), state(age_limit_ms=200.0)]
    states += [state(ready="link_too_slow", age_limit_ms=200.0)] * 3
    watch = RemoteWatch(States(*states), LEASE.session, lambda _: None)
    with capture_logs() as logs:
        for k in range(len(states)):
            watch.poll(k * 33 * NS_PER_MS)
    limits = [(line["ms"], line["speed"]) for line in logs if line["event"] == "age limit"]
    assert limits == [(200.0, "50%")]
    assert [line["reason"] for line in logs if line["event"] == "the link is too slow"] == ["the link takes 310 ms"]


def test_a_channel_comes_alive_and_falls_silent_once() -> None:
    health = ChannelHealth(stale_after_ns=100)
    assert health.change(0) is None
    health.seen(10)
    assert health.change(20) is True
    assert health.change(110) is None
    assert health.change(111) is False
    assert health.change(500) is None


def test_it_knows_the_settings_in_force_from_the_newest_state():
    watch = RemoteWatch(States(state(settings="old"), state(settings="new")), LEASE.session, lambda _: None)
    assert watch.settings is None
    watch.poll(0)
    watch.poll(1)
    assert watch.settings == "new"
