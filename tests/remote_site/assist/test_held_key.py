"""The key of fine adjustment: a press counts once, after a release that was seen, and 200 ms of silence end it."""

from common.clock import NS_PER_MS
from common.messages.hand import Intent
from remote_site.assist.assist import HeldKey
from tests.remote_site.assist.sightings import PRESSED, RELEASED


def key(*intents: Intent | None) -> HeldKey:
    """A key that was reported so, every 30 ms."""
    held = HeldKey()
    for k, intent in enumerate(intents):
        held.see(intent, 30 * k * NS_PER_MS)
    return held


def test_a_press_after_a_release_counts_once() -> None:
    held = key(RELEASED, PRESSED, PRESSED)
    assert held.held
    assert held.pressed() == "block"
    assert held.pressed() is None


def test_a_key_that_was_never_seen_up_counts_as_up() -> None:
    held = key(PRESSED, PRESSED)
    assert not held.held
    assert held.pressed() is None


def test_after_a_silence_of_the_page_it_has_to_be_released_first() -> None:
    assert not key(RELEASED, PRESSED, None, PRESSED).held
    assert key(RELEASED, PRESSED, None, RELEASED, PRESSED).held


def test_a_key_that_is_held_for_another_target_without_a_release_counts_as_up() -> None:
    held = key(RELEASED, PRESSED, Intent(assist="shelf"))
    assert not held.held
    assert not key(RELEASED, PRESSED, Intent(assist="shelf"), PRESSED).held
    assert held.pressed() is None


def test_200_ms_without_a_sample_end_it() -> None:
    held = key(RELEASED, PRESSED)
    assert held.lapse(230 * NS_PER_MS) is None
    assert held.held
    assert held.lapse(231 * NS_PER_MS) == 201 * NS_PER_MS
    assert not held.held
