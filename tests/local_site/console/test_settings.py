"""The operator's settings in the console: adopted from the remote site, changed by the operating page alone."""

from collections.abc import Iterator

import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import Intent, Locks, OperatorIntent, OperatorSettings
from tests.local_site.console.test_message_handler import LEASE, Room

LOCKED = OperatorSettings(lease=LEASE, revision=3, scale=0.5, locks=Locks(z=True))


@pytest.fixture
def room() -> Iterator[Room]:
    """A console that has just started: its operator holds the lease, and no state has come."""
    room = Room()
    room.adopt(None)
    yield room
    room.sites.slow.set()
    room.handler.close()


def sent(room: Room, now_ns: int = NS_PER_S) -> Intent | None:
    """What the console sends to the local site next."""
    room.handler.send_intent(now_ns)
    message = room.intent.messages[-1]
    assert isinstance(message, OperatorIntent)
    return message.intent


def test_before_the_first_state_no_settings_are_sent_and_none_can_be_changed(room: Room) -> None:
    room.say(room.first, type="steer", scale=2.0)
    room.say(room.first, type="new_origins")
    assert sent(room) == Intent(settings=None)
    room.adopt(LOCKED)
    assert sent(room) == Intent(settings=LOCKED)


def test_a_change_counts_from_the_settings_in_force(room: Room) -> None:
    room.adopt(LOCKED)
    room.say(room.first, type="steer", locks={"x": True})
    assert room.handler.settings == OperatorSettings(lease=LEASE, revision=4, scale=0.5, locks=Locks(x=True, z=True))
    room.say(room.first, type="new_origins")
    assert room.handler.settings is not None
    assert room.handler.settings.revision == 5


def test_what_is_no_change_takes_no_new_origins(room: Room) -> None:
    room.adopt(LOCKED)
    room.say(room.first, type="steer", scale=0.5, locks={"z": True})
    assert room.handler.settings == LOCKED


def test_a_state_from_before_a_change_does_not_take_it_back_and_one_after_it_does(room: Room) -> None:
    room.adopt(LOCKED)
    room.say(room.first, type="steer", scale=2.0)
    changed = room.handler.settings
    room.adopt(LOCKED)
    assert room.handler.settings == changed
    bounded = OperatorSettings(lease=LEASE, revision=4, scale=1.5, locks=Locks(z=True))
    room.adopt(bounded)
    assert room.handler.settings == bounded


def test_without_settings_in_force_none_are_known(room: Room) -> None:
    room.adopt(LOCKED)
    room.adopt(None)
    assert sent(room) == Intent(settings=None)


def test_a_change_in_another_console_of_the_operator_is_adopted(room: Room) -> None:
    room.adopt(LOCKED)
    room.say(room.first, type="steer", scale=2.0)
    elsewhere = OperatorSettings(lease=LEASE, revision=5, scale=0.1)
    room.adopt(elsewhere)
    assert room.handler.settings == elsewhere


def test_a_new_lease_brings_its_own_settings(room: Room) -> None:
    room.adopt(LOCKED)
    room.say(room.first, type="steer", scale=2.0)
    granted = OperatorSettings(lease=LEASE + 1)
    room.adopt(room.handler.settings, lease=LEASE + 1)
    assert sent(room) == Intent(settings=None)
    room.adopt(granted, lease=LEASE + 1)
    assert sent(room) == Intent(settings=granted)


def test_the_settings_of_another_operator_are_shown_and_neither_changed_nor_sent(room: Room) -> None:
    room.adopt(LOCKED, lease=0)
    room.say(room.first, type="steer", scale=2.0)
    assert room.handler.settings == LOCKED
    assert sent(room) == Intent(settings=None)


def test_a_page_that_falls_silent_is_reported_once(room: Room) -> None:
    assert sent(room) is not None
    silent_ns = NS_PER_S + 201 * NS_PER_MS
    assert sent(room, silent_ns) is None
    room.handler.send_intent(silent_ns + 20 * NS_PER_MS)
    assert len(room.intent.messages) == 2
    room.handler.seat.beat(room.first.visitor, silent_ns + 30 * NS_PER_MS, silent_ns, down=False)
    assert sent(room, silent_ns + 40 * NS_PER_MS) == Intent()


def test_a_page_that_leaves_the_controls_is_silent_at_once(room: Room) -> None:
    assert sent(room) is not None
    room.say(room.first, type="leave_seat", id=1)
    assert sent(room) is None


def test_where_nobody_has_operated_nothing_is_sent(room: Room) -> None:
    room.say(room.first, type="leave_seat", id=1)
    room.handler.send_intent(NS_PER_S)
    assert room.intent.messages == []


def test_a_change_that_is_not_in_force_after_a_second_is_dropped_and_never_takes_effect_later(room: Room) -> None:
    room.adopt(LOCKED)
    room.say(room.first, type="steer", locks={"z": False})
    changed = room.handler.settings
    room.adopt(LOCKED, 2 * NS_PER_S)
    assert room.handler.settings == changed
    room.adopt(LOCKED, 2 * NS_PER_S + 1)
    assert room.handler.settings == LOCKED
    assert sent(room) == Intent(settings=LOCKED)
    assert "not taken" in room.history.events[0].text
