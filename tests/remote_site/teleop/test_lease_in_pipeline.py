"""The lease in the pipeline: what was not sent under the lease in force moves nothing, however late it comes."""

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import ClockSync
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.session.lease import Holder
from tests.present import present
from tests.remote_site.remote_loop import RemoteLoop, hand, operator_of

TICKS_PER_SAMPLE = 8


def swaying(t_ns):
    t = t_ns / 1e9
    return (0.1 * np.sin(2.5 * t), 0.05 * np.sin(4 * t), 0.3 + 0.08 * np.sin(3 * t))


@pytest.fixture
def loop():
    return following()


def following():
    loop = RemoteLoop()
    loop.run(TICKS_PER_SAMPLE * 40, swaying)
    assert loop.states[-1] is SessionState.ENGAGED
    return loop


def test_a_second_operators_samples_are_counted_and_change_nothing(loop):
    before = loop.newest
    for k in range(40):
        now_ns = loop.clock.now_ns()
        others = hand(9000 + k, now_ns, (0.3, 0.3, 0.1), session=8, lease=k % 2 * loop.lease)
        own = hand(5000 + k, now_ns - NS_PER_MS, swaying(now_ns))
        loop.tick(others, own)
        assert loop.newest.sample.session == 7
    assert loop.states[-1] is SessionState.ENGAGED
    assert loop.newest is not before
    assert loop.snapshot.rejected[Code.NOT_HOLDER] == 40
    assert not loop.snapshot.rejected[Code.OLD_LEASE]


def test_another_operators_samples_under_the_holders_lease_and_session_change_nothing(loop):
    alone = following()
    loop.sender = "ben"
    for k in range(100):
        now_ns = loop.clock.now_ns()
        loop.tick(hand(10**6 + k, now_ns, (0.0, 0.1 + 0.001 * k, 0.3), lease=loop.lease))
    alone.run(100)
    np.testing.assert_array_equal(loop.arrays(), alone.arrays())
    assert loop.snapshot.rejected[Code.NOT_HOLDER] == 100
    loop.sender = ""
    loop.run(TICKS_PER_SAMPLE, swaying)
    assert loop.newest.sample.seq == loop.hand_seq


def test_a_late_sample_under_an_old_lease_is_fenced_though_it_is_young_and_in_order(loop):
    old = loop.lease
    loop.grant(7)
    late = hand(10_000, loop.clock.now_ns(), swaying(loop.clock.now_ns()), lease=old)
    loop.tick(late)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert loop.snapshot.rejected[Code.OLD_LEASE] == 1
    loop.tick(msgspec.structs.replace(late, lease=loop.lease))
    assert loop.newest.sample.lease == loop.lease


def test_a_lease_that_expires_in_motion_stops_and_latches(loop):
    now_ns = loop.clock.now_ns()
    loop.leases._lease = loop.leases.current(now_ns).__class__(
        loop.lease, Holder(7, operator_of(7)), now_ns + 40 * NS_PER_MS
    )
    loop.run(9, swaying)
    assert loop.states[-1] is SessionState.ENGAGED
    loop.run(150, swaying)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert loop.sent.resting
    loop.grant(7)
    loop.run(TICKS_PER_SAMPLE * 60, swaying)
    assert loop.states[-1] is SessionState.DISENGAGED
    assert loop.ask(EngagementAction.ENGAGE).done


def test_an_operator_who_takes_back_the_lease_is_heard_again(loop):
    loop.grant(8)
    loop.run(TICKS_PER_SAMPLE * 40, swaying, session=8)
    loop.grant(7)
    loop.run(TICKS_PER_SAMPLE * 40, swaying)
    assert loop.ask(EngagementAction.ENGAGE).done
    loop.run(2, swaying)
    assert loop.states[-1] is SessionState.ENGAGED


@pytest.mark.parametrize("apart_s", [-7200, 0, 7200])
def test_two_hosts_whose_clocks_differ_work_as_one(apart_s):
    loop = RemoteLoop()
    for k in range(TICKS_PER_SAMPLE * 60):
        now_ns = loop.clock.now_ns()
        clock = ClockSync(remote_minus_local_ns=apart_s * NS_PER_S, uncertainty_ns=1000, measured_ns=now_ns - NS_PER_S)
        theirs_ns = now_ns - apart_s * NS_PER_S
        sample = hand(k, theirs_ns, swaying(now_ns), clock=clock)
        loop.tick(*([sample] if k % TICKS_PER_SAMPLE == 0 else []))
    assert loop.states[-1] is SessionState.ENGAGED
    assert not loop.snapshot.rejected
    assert present(loop.snapshot.clock).remote_minus_local_ns == apart_s * NS_PER_S


def test_without_clock_offset_nothing_engages():
    loop = RemoteLoop()
    loop.run(TICKS_PER_SAMPLE * 60, swaying, clock=None)
    assert loop.states[-1] is SessionState.DISENGAGED
    answer = loop.ask(EngagementAction.ENGAGE)
    assert (answer.done, answer.reason.code) == (False, Code.NO_OFFSET)


@pytest.mark.slow
@pytest.mark.parametrize("ahead", [2, 255, 2**40])
def test_a_sample_with_a_damaged_number_holds_nothing_up(ahead: int) -> None:
    """It used to make every true sample after it an old one, until the local site was started again."""
    loop = following()
    capture_ns = loop.clock.now_ns()
    loop.tick(hand(loop.hand_seq + ahead, capture_ns, swaying(capture_ns)))
    loop.run(1000, swaying)
    assert loop.states[-1000:].count(SessionState.ENGAGED) == 1000
    assert not loop.snapshot.rejected
    assert loop.snapshot.hand_link is not None
    assert loop.snapshot.hand_link.loss == 0.0
