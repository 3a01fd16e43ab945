"""What is kept of each sender: of the lease's holder every hand sample, of everybody else so many bytes a second."""

import pytest

from common.clock import NS_PER_S
from common.link.channels import CHANNELS, HAND, LEASE, PROCEDURES, STATE
from common.link.roles import REMOTES
from remote_site.recording.message_budget import BURST_NS, KEPT_BYTES_PER_S, MOST_SENDERS, MessageBudget
from remote_site.recording.records import PassedMessage

CELL, SECONDS = "cell", 3
TICK_NS = NS_PER_S // 250
OF_OPERATORS = [
    keyed.key_for(CELL, operator="ben")
    for keyed in (*CHANNELS, *PROCEDURES)
    if keyed.by_operator and REMOTES & getattr(keyed, "received_by", getattr(keyed, "answered_by", REMOTES))
]


def hands(operator: str) -> str:
    return HAND.key_for(CELL, operator=operator)


def kept_bytes(budget: MessageBudget, key: str, size: int, *, sent: bool = False, refused: bool = False) -> int:
    """How much is kept of sixteen messages in each tick, while anna holds the lease."""
    flood = (PassedMessage(key, tick * TICK_NS, sent, bytes(size)) for tick in range(250 * SECONDS) for _ in range(16))
    return sum(size for message in flood if budget.keeps(message, "anna", refused=refused))


def test_the_holders_hand_samples_and_the_state_are_all_kept():
    sizes = (
        kept_bytes(MessageBudget(), hands("anna"), 200),
        kept_bytes(MessageBudget(), STATE.key_for(CELL), 200, sent=True),
    )
    assert sizes == (200 * 16 * 250 * SECONDS,) * 2


@pytest.mark.parametrize("key", OF_OPERATORS)
@pytest.mark.parametrize("size", [1, 4096])
def test_of_who_holds_no_lease_no_more_than_the_budget_is_kept(key: str, size: int) -> None:
    most = KEPT_BYTES_PER_S * (SECONDS + BURST_NS / NS_PER_S) + 4096
    assert 0 < kept_bytes(MessageBudget(), key, size) <= most


def test_what_is_no_hand_sample_is_bounded_on_the_holders_key_too():
    assert kept_bytes(MessageBudget(), hands("anna"), 4096, refused=True) < KEPT_BYTES_PER_S * (SECONDS + 2)


@pytest.mark.parametrize("key", ["farhand/cell/clock", "farhand/cell/rpc/describe", "nothing", "farhand/cell/hand/B n"])
def test_keys_that_name_no_operator_share_a_budget(key: str) -> None:
    assert kept_bytes(MessageBudget(), key, 4096, sent=True) < KEPT_BYTES_PER_S * (SECONDS + 2)


def test_one_operators_flood_leaves_anothers_samples_and_requests():
    budget = MessageBudget()
    for tick in range(250 * SECONDS):
        t_ns = tick * TICK_NS
        for _ in range(16):
            budget.keeps(PassedMessage(hands("ben"), t_ns, False, bytes(4096)), "anna")
        if tick % 4 == 0:  # 60 samples a second are fewer
            assert budget.keeps(PassedMessage(hands("carl"), t_ns, False, bytes(200)), "anna")
        if tick % 250 == 0:
            assert budget.keeps(PassedMessage(LEASE.key_for(CELL, operator="carl"), t_ns, False, bytes(300)), "anna")


def test_what_is_left_out_is_counted_and_told_once_a_minute():
    budget, told, kept, sent = MessageBudget(), [], 0, 0
    for tick in range(250 * 130):
        t_ns = tick * TICK_NS
        if tick < 250 * 90:
            sent += 1
            kept += budget.keeps(PassedMessage(hands("ben"), t_ns, False, bytes(4096)), "anna")
        told += budget.take_left_out(t_ns)
    assert [left.t_ns // NS_PER_S for left in told] == [1, 61, 121]
    assert {left.operator for left in told} == {"ben"}
    assert sum(left.messages for left in told) == sent - kept
    assert sum(left.size for left in told) == 4096 * (sent - kept)


def test_invented_names_share_a_budget():
    budget = MessageBudget()
    names = [f"invented-{k}" for k in range(1000)]
    kept = sum(budget.keeps(PassedMessage(hands(name), 0, False, bytes(4096)), "") for name in names for _ in range(50))
    assert kept * 4096 < (MOST_SENDERS + 1) * 2 * KEPT_BYTES_PER_S
