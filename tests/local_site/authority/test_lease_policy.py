"""The local site's part of the lease: renewed in time, never believed too long, not taken from another by waiting."""

import pytest

from common.clock import NS_PER_S
from common.messages.requests import LeaseAction, LeaseReply
from local_site.authority.lease_policy import LeasePolicy

S = NS_PER_S


def granted(number=41, lasts_ns=5 * S):
    return LeaseReply(id=1, done=True, code="lease_held", reason="", lease=number, lasts_ns=lasts_ns, holder="anna")


def refused(holder="", session=8, lasts_ns=0):
    return LeaseReply(
        id=1, done=False, code="not_holder", reason="", holder=holder, holder_session=session, lasts_ns=lasts_ns
    )


def holding():
    policy = LeasePolicy("anna", automatic=True)
    assert policy.due(0) is LeaseAction.ACQUIRE
    policy.asked(0)
    policy.take_reply(granted(), 0, 0)
    return policy


def test_it_renews_every_second_and_holds_from_the_asking_for_five():
    policy = holding()
    assert policy.held(0) == 41
    assert policy.due(S - 1) is None
    assert policy.due(S) is LeaseAction.RENEW
    policy.asked(S)
    assert policy.due(S + 1) is None
    policy.take_reply(granted(), S, S)
    assert policy.held(6 * S - 1) == 41
    assert policy.held(6 * S) == 0


def test_unanswered_renewals_are_repeated_until_it_expires_and_is_asked_for_anew():
    policy, asked, now_ns = holding(), [], 0
    while now_ns < 7 * S:
        now_ns += S // 50
        action = policy.due(now_ns)
        if action is not None:
            asked.append((action, now_ns))
            policy.asked(now_ns)
    renewals = [t for action, t in asked if action is LeaseAction.RENEW]
    assert renewals[0] == S
    assert len(renewals) >= 4
    assert max(renewals) < 5 * S
    assert (LeaseAction.ACQUIRE, pytest.approx(5.9 * S, abs=1.01 * S)) in asked
    assert policy.held(now_ns) == 0


def test_a_refused_renewal_leads_to_a_new_lease():
    policy = holding()
    policy.asked(S)
    policy.take_reply(refused(), S, S)
    assert policy.held(S) == 0
    assert policy.due(2 * S) is LeaseAction.ACQUIRE


def test_who_is_refused_for_another_does_not_wait_for_the_others_link_to_fail():
    policy = LeasePolicy("anna", automatic=True)
    policy.asked(0)
    policy.take_reply(refused("ben"), 0, 0)
    assert policy.due(100 * S) is None


def test_a_restarted_site_waits_for_its_own_former_lease_to_expire():
    policy = LeasePolicy("anna", automatic=True)
    for k in range(5):  # nobody renews it; replies come late, each by another time
        assert policy.due(k * S) is LeaseAction.ACQUIRE
        policy.asked(k * S)
        policy.take_reply(refused("anna", lasts_ns=5 * S - k * S - k % 2 * S // 2), k * S, k * S + S // 2)
        assert policy.asks_by_itself
    assert policy.due(5 * S) is LeaseAction.ACQUIRE


@pytest.mark.parametrize("apart", [1, 3])
def test_a_site_does_not_wait_for_the_link_of_another_host_of_the_same_name_to_fail(apart):
    policy, renewed_ns = LeasePolicy("anna", automatic=True), 0
    for k in range(2 * apart):
        policy.asked(k * S)
        renewed_ns = k // apart * apart * S  # the other host renews it
        policy.take_reply(refused("anna", lasts_ns=renewed_ns + 5 * S - k * S), k * S, k * S + S // 10)
    assert not policy.asks_by_itself
    assert policy.due(100 * S) is None


def test_a_lease_that_was_taken_on_request_is_asked_for_automatically_again():
    policy = holding()
    policy.stop_asking()
    policy.take_reply(refused(), S, S)
    assert policy.due(2 * S) is None
    policy.keep_asking(3 * S)
    assert policy.due(3 * S) is LeaseAction.ACQUIRE
    policy.asked(3 * S)
    policy.take_reply(granted(), 3 * S, 3 * S)
    assert policy.due(9 * S) is LeaseAction.ACQUIRE, "it has expired, as behind a link that was cut"


def test_who_does_not_want_it_automatically_does_not_get_it_so_after_taking_it():
    policy = LeasePolicy("anna", automatic=False)
    policy.keep_asking(0)
    policy.asked(0)
    policy.take_reply(granted(), 0, 0)
    assert policy.due(9 * S) is None


def test_it_insists_for_a_minute_when_the_operator_says_so():
    policy = LeasePolicy("anna", automatic=False)
    assert policy.due(0) is None
    policy.keep_asking(0)
    for k in range(60):
        assert policy.due(k * S) is LeaseAction.ACQUIRE
        policy.asked(k * S)
        policy.take_reply(refused("ben"), k * S, k * S)
        policy.keep_asking(k * S)  # said again meanwhile, it does not begin anew
    assert policy.due(61 * S) is None


def test_what_the_operator_gave_away_is_not_asked_for_again():
    policy = holding()
    policy.take_reply(refused("ben"), S, S)
    policy.stop_asking()
    assert policy.due(50 * S) is None


@pytest.mark.parametrize("late", [False, True])
def test_who_insists_and_then_gives_it_away_asks_no_more(late):
    """Nor after a reply that was under way meanwhile has granted it: that lease ends, and is not asked for again."""
    policy = LeasePolicy("anna", automatic=True)
    policy.keep_asking(0)
    assert policy.due(0) is LeaseAction.ACQUIRE
    policy.asked(0)
    policy.stop_asking()
    if late:
        policy.take_reply(granted(), 0, S // 2)
    assert [policy.due(6 * S + k * S) for k in range(60)] == [None] * 60


def test_a_grant_that_comes_after_a_refusal_for_another_is_not_asked_for_again():
    policy = holding()
    policy.keep_asking(S)
    policy.take_reply(granted(), S, S)
    policy.take_reply(refused("ben"), 2 * S, 2 * S)
    policy.take_reply(granted(), S, 2 * S)
    assert policy.due(10 * S) is None
