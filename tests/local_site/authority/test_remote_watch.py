"""What the local site makes of the remote's states: whether the arm is engaged, and by this site."""

from types import SimpleNamespace

from structlog.testing import capture_logs

from common.clock import NS_PER_MS
from local_site.authority.remote_watch import ChannelHealth, RemoteWatch

LEASE = SimpleNamespace(session=7, asked_by=None)


def state(engagement=None, word="engaged", code="following"):
    return SimpleNamespace(state=SimpleNamespace(value=word), code=code, reason="", lease=LEASE, engagement=engagement)


class States:
    """Gives one state after another."""

    def __init__(self, *states):
        self._states = list(states)

    def take(self):
        return self._states.pop(0) if self._states else None


def test_who_waits_is_told_of_the_hands_origin_under_the_own_lease_alone():
    for session, told in ((LEASE.session, [123]), (LEASE.session + 1, [])):
        heard = []
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


def test_a_channel_comes_alive_and_falls_silent_once() -> None:
    health = ChannelHealth(stale_after_ns=100)
    assert health.change(0) is None
    health.seen(10)
    assert health.change(20) is True
    assert health.change(110) is None
    assert health.change(111) is False
    assert health.change(500) is None
