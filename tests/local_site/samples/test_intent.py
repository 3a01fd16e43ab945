"""The merge of the operator's intent: held only while a page reports it, and only after it was seen released."""

import pytest

from common.clock import NS_PER_MS
from common.messages.hand import Intent, Locks, OperatorIntent
from local_site.samples.hand_sample import IntentMerge

MS = NS_PER_MS
START = 1000 * MS


def told(at_ms, hold, **changes):
    return OperatorIntent(sent_ns=START + at_ms * MS, intent=Intent(hold=hold, **changes))


def merge(*messages):
    made = IntentMerge()
    for message in messages:
        made.receive(message, message.sent_ns)
    return made


def test_what_nobody_has_told_is_not_held():
    assert IntentMerge().at(START) == Intent()


def test_a_press_after_a_release_is_held():
    assert merge(told(0, False), told(50, True)).at(START + 60 * MS).hold


def test_intent_older_than_200_ms_is_not_held():
    made = merge(told(0, False), told(50, True))
    assert made.at(START + 250 * MS).hold
    assert not made.at(START + 250 * MS + 1).hold


@pytest.mark.parametrize("looked", [True, False])
def test_after_a_silence_the_key_has_to_be_let_go_first(looked):
    made = merge(told(0, False), told(50, True))
    if looked:
        assert not made.at(START + 300 * MS).hold
    made.receive(told(400, True), START + 400 * MS)
    assert not made.at(START + 400 * MS).hold
    made.receive(told(450, False), START + 450 * MS)
    made.receive(told(500, True), START + 500 * MS)
    assert made.at(START + 500 * MS).hold


def test_a_key_that_is_down_from_the_start_is_not_held():
    assert not merge(told(0, True), told(50, True)).at(START + 60 * MS).hold


def test_what_comes_late_or_from_the_future_is_left_out():
    made = merge(told(0, False), told(100, True))
    made.receive(told(50, False), START + 110 * MS)
    made.receive(told(900, False), START + 110 * MS)
    assert made.at(START + 120 * MS).hold


def test_scales_locks_and_clutch_stay_as_last_told():
    locks = Locks(z=True)
    made = merge(told(0, False, scale=0.5, rotation_scale=0.0, clutch_count=3, locks=locks))
    assert made.at(START + 5000 * MS) == Intent(scale=0.5, rotation_scale=0.0, clutch_count=3, locks=locks)
