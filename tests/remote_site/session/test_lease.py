"""The lease: one holder, for a while, and never back under a number that has ended."""

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from common.clock import NS_PER_S
from common.messages.requests import LeaseAction, LeaseReply, LeaseRequest
from common.messages.robot import Asker
from remote_site.reasons import Code, Reason
from remote_site.runtime.request_server import answer_lease
from remote_site.session.lease import Holder, Lease, LeaseServer

ANNA, BEN, CARL = Holder(7, "anna"), Holder(8, "ben"), Holder(9, "carl")
LASTS = 5 * NS_PER_S
FIRST = 1000


@pytest.fixture
def desk():
    return LeaseServer(LASTS, FIRST)


def code(outcome):
    assert isinstance(outcome, Reason), outcome
    return outcome.code


def test_who_asks_first_gets_it_and_the_other_is_refused_with_the_holders_name(desk):
    lease = desk.acquire(ANNA, 0)
    assert (lease.number, lease.holder, lease.expires_ns) == (FIRST, ANNA, LASTS)
    refused = desk.acquire(BEN, 1)
    assert code(refused) is Code.NOT_HOLDER
    assert "anna" in refused.sentence
    assert desk.current(1) == lease


def test_it_lasts_five_seconds_from_the_last_renewal_and_not_a_nanosecond_longer(desk):
    number = desk.acquire(ANNA, 0).number
    desk.renew(number, ANNA, NS_PER_S)
    assert desk.current(NS_PER_S + LASTS - 1).holder is ANNA
    assert desk.current(NS_PER_S + LASTS) is None


def test_an_expired_lease_is_not_renewed_but_acquired_anew_under_another_number(desk):
    number = desk.acquire(ANNA, 0).number
    assert code(desk.renew(number, ANNA, LASTS)) is Code.OLD_LEASE
    assert desk.acquire(ANNA, LASTS).number == number + 1
    assert code(desk.in_force(number, ANNA, LASTS)) is Code.OLD_LEASE


def test_expiry_frees_it_for_another(desk):
    desk.acquire(ANNA, 0)
    assert desk.acquire(BEN, LASTS).holder is BEN


def test_release_frees_it_at_once_and_only_the_holder_can(desk):
    number = desk.acquire(ANNA, 0).number
    assert code(desk.release(number, BEN, 1)) is Code.NOT_HOLDER
    assert code(desk.release(0, BEN, 1)) is Code.NOT_HOLDER
    assert desk.release(number, ANNA, 1).holder is ANNA
    assert desk.current(1) is None
    assert desk.acquire(BEN, 1).holder is BEN


def test_consent_hands_it_to_who_asks_and_to_nobody_else(desk):
    number = desk.acquire(ANNA, 0).number
    assert code(desk.hand_over(number, ANNA, BEN, 1)) is Code.NOBODY_ASKS
    desk.acquire(BEN, 2)
    assert desk.asker(2) is BEN
    assert code(desk.hand_over(number, BEN, BEN, 3)) is Code.NOT_HOLDER
    handed = desk.hand_over(number, ANNA, BEN, 3)
    assert (handed.holder, handed.number) == (BEN, number + 1)
    assert desk.asker(3) is None
    assert code(desk.renew(number, ANNA, 4)) is Code.OLD_LEASE
    assert desk.acquire(BEN, 4).number == number + 1


@pytest.mark.parametrize("shown", [None, CARL, Holder(BEN.session, "carl"), Holder(CARL.session, "ben")])
def test_consent_for_somebody_else_hands_nothing_over_and_names_who_asks_now(desk, shown):
    number = desk.acquire(ANNA, 0).number
    desk.acquire(CARL, 1)
    later = LASTS + 1
    desk.renew(number, ANNA, LASTS - 1)
    desk.acquire(BEN, later)
    refused = desk.hand_over(number, ANNA, shown, later)
    assert code(refused) is Code.ASKER_CHANGED
    assert refused.sentence.startswith("ben (site 8) asks for the lease now")
    assert desk.current(later).holder is ANNA
    assert desk.hand_over(number, ANNA, BEN, later).holder is BEN


def test_of_several_who_ask_the_first_stays_named_while_asking(desk):
    number = desk.acquire(ANNA, 0).number
    desk.acquire(CARL, 1)
    assert code(desk.acquire(BEN, 2)) is Code.NOT_HOLDER
    assert desk.asker(2) is CARL
    desk.renew(number, ANNA, LASTS - 1)
    desk.acquire(CARL, LASTS)
    desk.acquire(BEN, LASTS + 1)
    assert desk.asker(LASTS + 1) is CARL
    assert desk.hand_over(number, ANNA, CARL, LASTS + 1).holder is CARL


def test_who_asks_and_restarts_is_named_once_the_former_site_has_not_asked_for_a_while(desk):
    """Until then another host of that name could take its place under a consent that was for the first."""
    number = desk.acquire(ANNA, 0).number
    desk.acquire(CARL, 1)
    other = Holder(CARL.session + 1, CARL.name)
    assert "anna (site 7) holds" in desk.acquire(other, 2).sentence
    assert desk.asker(2) is CARL
    desk.renew(number, ANNA, LASTS - 1)
    desk.acquire(other, LASTS + 1)
    assert desk.asker(LASTS + 1) is other


def test_another_operator_with_the_holders_session_is_refused(desk):
    desk.acquire(ANNA, 0)
    assert code(desk.acquire(Holder(ANNA.session, "ben"), 1)) is Code.NOT_HOLDER
    assert desk.current(1).holder is ANNA


def test_who_has_not_asked_for_a_while_is_not_handed_it(desk):
    number = desk.acquire(ANNA, 0).number
    desk.acquire(BEN, 0)
    desk.renew(number, ANNA, NS_PER_S)
    assert code(desk.hand_over(number, ANNA, BEN, LASTS)) is Code.NOBODY_ASKS


def test_the_same_operator_after_a_restart_is_another_holder(desk):
    desk.acquire(ANNA, 0)
    assert code(desk.acquire(Holder(70, "anna"), 1)) is Code.NOT_HOLDER


@pytest.mark.parametrize(
    ("number", "client", "expected"),
    [
        (0, BEN, Code.NOT_HOLDER),
        (FIRST, BEN, Code.NOT_HOLDER),
        (FIRST, Holder(ANNA.session, "ben"), Code.NOT_HOLDER),
        (FIRST, Holder(BEN.session, "anna"), Code.NOT_HOLDER),
        (FIRST - 1, ANNA, Code.OLD_LEASE),
        (FIRST + 1, ANNA, Code.OLD_LEASE),
    ],
)
def test_what_is_sent_under_another_number_or_by_another_site_is_fenced(desk, number, client, expected):
    desk.acquire(ANNA, 0)
    assert code(desk.in_force(number, client, 1)) is expected
    assert desk.in_force(FIRST, ANNA, 1).holder is ANNA


def test_without_a_lease_nothing_is_in_force(desk):
    assert code(desk.in_force(0, ANNA, 0)) is Code.NO_LEASE
    assert code(desk.in_force(FIRST, ANNA, 0)) is Code.OLD_LEASE


def ask(desk, action, holder=ANNA, lease=0, now_ns=0, to=None):
    request = LeaseRequest(id=3, deadline_ns=9, action=action, session=holder.session, lease=lease, to=to)
    return answer_lease(desk, request, holder.name, now_ns)


def test_replies_tell_the_askers_lease_and_the_holders_name(desk):
    granted = ask(desk, LeaseAction.ACQUIRE)
    assert granted == LeaseReply(
        id=3,
        done=True,
        code="lease_held",
        reason=granted.reason,
        lease=FIRST,
        lasts_ns=LASTS,
        holder="anna",
        holder_session=7,
    )
    refused = ask(desk, LeaseAction.ACQUIRE, BEN, now_ns=1)
    assert (refused.done, refused.code, refused.lease, refused.holder) == (False, "not_holder", 0, "anna")
    assert (refused.holder_session, refused.lasts_ns) == (7, LASTS - 1)
    renewed = ask(desk, LeaseAction.RENEW, lease=FIRST, now_ns=2)
    assert (renewed.done, renewed.lease, renewed.lasts_ns) == (True, FIRST, LASTS)
    given = ask(desk, LeaseAction.HAND_OVER, lease=FIRST, now_ns=3, to=Asker(BEN.name, BEN.session))
    assert (given.done, given.code, given.lease, given.holder) == (True, "handed_over", 0, "ben")
    assert "ben" in given.reason
    released = ask(desk, LeaseAction.RELEASE, BEN, lease=FIRST + 1, now_ns=4)
    assert (released.done, released.code, released.lease, released.holder) == (True, "lease_released", 0, "")


class LeaseMachine(RuleBasedStateMachine):
    """Three sites act at random; a plain record of the granted leases shows what must hold."""

    holders = st.sampled_from([ANNA, BEN, CARL])

    def __init__(self):
        super().__init__()
        self.desk = LeaseServer(LASTS, FIRST)
        self.now_ns = 0
        self.numbers: dict[int, Holder] = {}
        self.ended: set[int] = set()
        self.in_force: Lease | None = None
        self.asked: dict[Holder, int] = {}

    def note(self, lease):
        """Every grant has a new number or is the holder's own, and lasts from now."""
        assert lease.expires_ns == self.now_ns + LASTS
        assert lease.number not in self.ended
        assert self.numbers.setdefault(lease.number, lease.holder) == lease.holder
        assert lease.number == max(self.numbers)
        if self.in_force is not None and self.in_force.number != lease.number:
            self.ended.add(self.in_force.number)
        self.in_force = lease

    def end(self):
        if self.in_force is not None:
            self.ended.add(self.in_force.number)
        self.in_force = None

    @rule(milliseconds=st.sampled_from([0, 1, 900, 2500, 4999, 5000, 12000]))
    def pass_time(self, milliseconds):
        self.now_ns += milliseconds * 1_000_000
        if self.in_force is not None and self.now_ns >= self.in_force.expires_ns:
            self.end()

    @rule(holder=holders)
    def acquire(self, holder):
        outcome = self.desk.acquire(holder, self.now_ns)
        if self.in_force is None or self.in_force.holder is holder:
            self.note(outcome)
        else:
            assert isinstance(outcome, Reason)
            assert self.in_force.holder.name in outcome.sentence
            self.asked[holder] = self.now_ns

    @rule(holder=holders, back=st.integers(0, 3))
    def renew(self, holder, back):
        number = max(self.numbers, default=FIRST) - back
        outcome = self.desk.renew(number, holder, self.now_ns)
        if self.owns(number, holder):
            self.note(outcome)
        else:
            assert isinstance(outcome, Reason)

    @rule(holder=holders, back=st.integers(0, 3))
    def release(self, holder, back):
        number = max(self.numbers, default=FIRST) - back
        owned = self.owns(number, holder)
        assert isinstance(self.desk.release(number, holder, self.now_ns), Lease) is owned
        if owned:
            self.end()

    @rule(holder=holders, to=holders, back=st.integers(0, 3))
    def hand_over(self, holder, to, back):
        number = max(self.numbers, default=FIRST) - back
        outcome = self.desk.hand_over(number, holder, to, self.now_ns)
        if isinstance(outcome, Lease):
            assert outcome.holder is to
            assert self.owns(number, holder)
            assert self.now_ns - self.asked[outcome.holder] < LASTS
            assert outcome.holder is not holder
            self.note(outcome)

    def owns(self, number, holder):
        return self.in_force is not None and (self.in_force.number, self.in_force.holder) == (number, holder)

    @invariant()
    def there_is_one_holder_and_only_the_lease_in_force_passes(self):
        assert self.desk.current(self.now_ns) == self.in_force
        for number in (*self.numbers, 0, max(self.numbers, default=FIRST) + 1):
            for holder in (ANNA, BEN, CARL, Holder(ANNA.session, "ben")):
                passed = isinstance(self.desk.in_force(number, holder, self.now_ns), Lease)
                assert passed is self.owns(number, holder)


TestLeaseMachine = LeaseMachine.TestCase
TestLeaseMachine.settings = settings(max_examples=80, stateful_step_count=30, deadline=None, derandomize=True)
