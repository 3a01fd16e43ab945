"""The local site's part of the lease: renewed in time, never believed too long, not taken from another by waiting."""

import pytest

from common.clock import NS_PER_S
from common.messages.requests import LeaseAction, LeaseReply
from local_site.authority.lease_policy import LeaseKeeper

S = NS_PER_S


def granted(number=41, lasts_ns=5 * S):
    return LeaseReply(id=1, done=True, code="lease_held", reason="", lease=number, lasts_ns=lasts_ns, holder="anna")


def refused(holder=""):
    return LeaseReply(id=1, done=False, code="not_holder", reason="", holder=holder)


def holding():
    keeper = LeaseKeeper("anna", automatic=True)
    assert keeper.due(0) is LeaseAction.ACQUIRE
    keeper.asked(0)
    keeper.heard(granted(), 0)
    return keeper


def test_it_renews_every_second_and_holds_from_the_asking_for_five():
    keeper = holding()
    assert keeper.held(0) == 41
    assert keeper.due(S - 1) is None
    assert keeper.due(S) is LeaseAction.RENEW
    keeper.asked(S)
    assert keeper.due(S + 1) is None
    keeper.heard(granted(), S)
    assert keeper.held(6 * S - 1) == 41
    assert keeper.held(6 * S) == 0


def test_unanswered_renewals_are_repeated_until_it_expires_and_is_asked_for_anew():
    keeper, asked, now_ns = holding(), [], 0
    while now_ns < 7 * S:
        now_ns += S // 50
        action = keeper.due(now_ns)
        if action is not None:
            asked.append((action, now_ns))
            keeper.asked(now_ns)
    renewals = [t for action, t in asked if action is LeaseAction.RENEW]
    assert renewals[0] == S
    assert len(renewals) >= 4
    assert max(renewals) < 5 * S
    assert (LeaseAction.ACQUIRE, pytest.approx(5.9 * S, abs=1.01 * S)) in asked
    assert keeper.held(now_ns) == 0


def test_a_refused_renewal_leads_to_a_new_lease():
    keeper = holding()
    keeper.asked(S)
    keeper.heard(refused(), S)
    assert keeper.held(S) == 0
    assert keeper.due(2 * S) is LeaseAction.ACQUIRE


def test_who_is_refused_for_another_does_not_wait_for_the_others_link_to_fail():
    keeper = LeaseKeeper("anna", automatic=True)
    keeper.asked(0)
    keeper.heard(refused("ben"), 0)
    assert keeper.due(100 * S) is None


def test_a_restarted_site_waits_for_its_own_former_lease_to_expire():
    keeper = LeaseKeeper("anna", automatic=True)
    keeper.asked(0)
    keeper.heard(refused("anna"), 0)
    assert keeper.due(S) is LeaseAction.ACQUIRE


def test_it_insists_for_a_minute_when_the_operator_says_so():
    keeper = LeaseKeeper("anna", automatic=False)
    assert keeper.due(0) is None
    keeper.insist(0)
    for k in range(60):
        assert keeper.due(k * S) is LeaseAction.ACQUIRE
        keeper.asked(k * S)
        keeper.heard(refused("ben"), k * S)
    assert keeper.due(61 * S) is None


def test_what_the_operator_gave_away_is_not_asked_for_again():
    keeper = holding()
    keeper.heard(refused("ben"), S)
    keeper.rest()
    assert keeper.due(50 * S) is None
