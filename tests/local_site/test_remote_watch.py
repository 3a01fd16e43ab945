"""What the local site makes of the remote's states: it is told that the arm is engaged, by this site alone."""

from types import SimpleNamespace

from local_site.remote_watch import RemoteWatch

LEASE = SimpleNamespace(session=7, asked_by=None)


def state(engagement):
    return SimpleNamespace(
        state=SimpleNamespace(value="engaged"), code="following", reason="", lease=LEASE, engagement=engagement
    )


class States:
    """Gives one state after another."""

    def __init__(self, *states):
        self._states = list(states)

    def take(self):
        return self._states.pop(0) if self._states else None


def test_who_waits_is_told_of_the_hands_origin_under_the_own_lease_alone():
    for session, told in ((LEASE.session, [123]), (LEASE.session + 1, [])):
        heard = []
        states = States(state(None), state(SimpleNamespace(hand_capture_ns=123)))
        watch = RemoteWatch(states, session, heard.append)
        watch.look(1)
        assert heard == []
        watch.look(2)
        assert heard == told
