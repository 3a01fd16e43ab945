"""The merge of the operator's intent: held only while a page reports it, and only after it was seen released."""

from typing import Any

import pytest

from common.clock import NS_PER_MS
from common.messages.hand import ClutchKey, Intent, Locks, OperatorIntent, OperatorSettings
from local_site.samples.hand_sample import IntentMerge, unless_in_force

MS = NS_PER_MS
START = 1000 * MS
UP, DOWN, UNSEEN = ClutchKey


def told(at_ms, hold, sender=7, **changes):
    intent = Intent(hold=hold, settings=OperatorSettings(**changes))
    return OperatorIntent(session=sender, sent_ns=START + at_ms * MS, intent=intent)


def merge(*messages):
    made = IntentMerge()
    for message in messages:
        made.receive(message, message.sent_ns)
    return made


def silent(at_ms, sender=7):
    return OperatorIntent(session=sender, sent_ns=START + at_ms * MS, intent=None)


def test_where_nobody_has_reported_there_is_no_intent():
    assert IntentMerge().at(START) is None


def test_a_press_after_a_release_is_held():
    assert merge(told(0, False), told(50, True)).at(START + 60 * MS).hold


def test_of_two_intents_of_the_same_instant_the_first_counts():
    assert not merge(told(0, False), told(50, False), told(50, True)).at(START + 60 * MS).hold
    assert merge(told(0, False), told(50, True), told(50, False)).at(START + 60 * MS).hold


def test_there_is_no_intent_200_ms_after_the_last():
    made = merge(told(0, False), told(50, True))
    assert made.at(START + 250 * MS).hold
    assert made.at(START + 250 * MS + 1) is None


def test_there_is_no_intent_as_soon_as_its_sender_says_that_the_page_is_silent():
    assert merge(told(0, False), told(50, True), silent(60)).at(START + 60 * MS) is None


def test_after_a_reported_silence_the_key_has_to_be_let_go_first():
    made = merge(told(0, False), told(50, True), silent(60), told(80, True))
    assert not made.at(START + 80 * MS).hold
    made.receive(told(100, False), START + 100 * MS)
    made.receive(told(120, True), START + 120 * MS)
    assert made.at(START + 120 * MS).hold


@pytest.mark.parametrize("looked", [True, False])
def test_after_a_silence_the_key_has_to_be_let_go_first(looked):
    made = merge(told(0, False), told(50, True))
    if looked:
        assert made.at(START + 300 * MS) is None
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


def test_the_settings_are_passed_on_as_they_were_sent():
    settings: dict[str, Any] = {"lease": 41, "revision": 3, "scale": 0.5, "rotation_scale": 0.0, "locks": Locks(z=True)}
    made = merge(told(0, False, **settings))
    assert made.at(START + 200 * MS) == Intent(settings=OperatorSettings(**settings))


def test_what_a_second_console_reports_is_no_release_of_the_first_ones_key():
    made = merge(told(0, True), told(10, False, sender=8), told(50, True))
    assert not made.at(START + 50 * MS).hold


def test_while_a_console_reports_another_neither_holds_nor_sets_nor_silences_anything():
    made = merge(told(0, False, revision=2), told(10, True, sender=8, revision=3), silent(20, sender=8))
    assert made.at(START + 20 * MS) == Intent(settings=OperatorSettings(revision=2))


@pytest.mark.parametrize("ending", [[], [silent(40)]])
def test_a_second_console_counts_once_the_first_is_silent_and_its_key_was_seen_released(ending):
    made = merge(told(0, False), told(30, True), *ending, told(231, True, sender=8))
    assert made.at(START + 231 * MS) == Intent(settings=OperatorSettings())
    made.receive(told(250, False, sender=8), START + 250 * MS)
    made.receive(told(270, True, sender=8), START + 270 * MS)
    assert made.at(START + 270 * MS).hold


def test_settings_are_sent_until_they_are_in_force():
    intent = Intent(hold=True, settings=OperatorSettings(lease=5, revision=3, scale=0.5))
    for in_force in (None, OperatorSettings(lease=5, revision=2), OperatorSettings(lease=4, revision=9)):
        assert unless_in_force(intent, in_force) == intent
    for revision in (3, 4):
        assert unless_in_force(intent, OperatorSettings(lease=5, revision=revision)) == Intent(hold=True)
    assert unless_in_force(None, OperatorSettings()) is None
    assert unless_in_force(Intent(hold=True), OperatorSettings()) == Intent(hold=True)


def clutch(at_ms, key, sender=7):
    return OperatorIntent(session=sender, sent_ns=START + at_ms * MS, intent=Intent(clutch=key))


def test_the_clutch_is_as_it_is_reported_from_the_first_report():
    made = merge(clutch(0, DOWN))
    assert made.at(START + 200 * MS).clutch is DOWN
    made.receive(clutch(40, UP), START + 40 * MS)
    assert made.at(START + 40 * MS).clutch is UP


@pytest.mark.parametrize("looked", [True, False])
@pytest.mark.parametrize(
    "interruption",
    [[], [silent(60)], [clutch(60, UNSEEN)], [clutch(260, UP, sender=8)]],
    ids=["no report", "a page that is silent", "no release seen", "another console"],
)
def test_after_an_interruption_only_a_press_and_its_release_let_go_of_the_clutch(interruption, looked):
    made = merge(clutch(0, UP), clutch(50, DOWN), *interruption)
    if looked and not interruption:
        assert made.at(START + 300 * MS) is None
    sender = interruption[-1].session if interruption else 7
    for k in range(3):
        made.receive(clutch(300 + 50 * k, UP, sender), START + (300 + 50 * k) * MS)
        assert made.at(START + (300 + 50 * k) * MS).clutch is UNSEEN
    made.receive(clutch(500, DOWN, sender), START + 500 * MS)
    made.receive(clutch(550, UP, sender), START + 550 * MS)
    assert made.at(START + 550 * MS).clutch is UP


def test_a_second_console_neither_clutches_nor_lets_go():
    made = merge(clutch(0, DOWN), clutch(10, UP, sender=8))
    assert made.at(START + 20 * MS).clutch is DOWN
    made.receive(clutch(30, UP), START + 30 * MS)
    made.receive(clutch(40, DOWN, sender=8), START + 40 * MS)
    assert made.at(START + 40 * MS).clutch is UP


def test_a_release_that_waited_for_longer_than_it_counts_lets_nothing_go():
    made = merge(clutch(0, DOWN))
    made.receive(clutch(100, UP), START + 400 * MS)
    assert made.at(START + 400 * MS) is None
    made.receive(clutch(420, UP), START + 420 * MS)
    assert made.at(START + 420 * MS).clutch is UNSEEN
