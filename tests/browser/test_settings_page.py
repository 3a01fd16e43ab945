"""The operator's settings on the page: those in force are shown, and nothing that comes back changes them."""

import time
from collections.abc import Callable
from functools import partial

import pytest

from common.messages.hand import Locks, OperatorSettings
from common.messages.robot import LeaseState, RobotState, SessionState
from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from tests.browser.opened_page import OpenedPage
from tests.browser.told import Told
from tests.present import present

LEASE = 5  # the scene's
LOCKED = OperatorSettings(lease=LEASE, revision=3, scale=0.5, locks=Locks(z=True))
SILENCES = 60
CHANGED = "scales or locks are no longer those that this page showed"


def under(settings: OperatorSettings) -> Callable[[], RobotState]:
    """States under which these settings are in force."""
    lease = LeaseState(settings.lease, "anna", 7, 2**62, None)
    return partial(scene.state, SessionState.ENGAGED, "ok", "", settings=settings, lease=lease)


def shows_locked(page: OpenedPage) -> bool:
    pressed = page.page.get_attribute("[data-lock=z]", "aria-pressed")
    return pressed == "true" and page.words("#scale-value") == "0.50"


@pytest.mark.slow
def test_a_page_adopts_the_settings_in_force_before_any_are_sent(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, console.address)
        told = Told(console, page)
        page.wait_for("the seat", lambda: "you operate" in page.words("#seat"))
        page.wait_for("intents", lambda: len(console.intents) > 5)
        for control in ("#scale", "#rotation", "[data-lock=z]", "#origins"):
            assert page.page.is_disabled(control), control
        assert {told.intent.settings for told in console.intents if told.intent is not None} == {None}

        told.state = under(LOCKED)
        told.until("the lock", lambda: shows_locked(page))
        told.until("the settings", lambda: present(console.intents[-1].intent).settings == LOCKED)
        page.page.click("[data-lock=x]")
        told.until(
            "the change", lambda: present(present(console.intents[-1].intent).settings).locks == Locks(x=True, z=True)
        )
        sent = [told.intent.settings for told in console.intents if told.intent is not None]
        assert all(settings is None or settings.locks.z for settings in sent)
        page.close()


@pytest.mark.slow
def test_a_page_that_reconnects_to_a_new_console_still_shows_the_lock(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, console.address)
        told = Told(console, page)
        told.state = under(LOCKED)
        told.until("the lock", lambda: shows_locked(page))
        port = int(console.address.rsplit(":", 1)[1].rstrip("/"))
    page.wait_for("the end", lambda: page.state() == "no connection")
    with BareConsole(port) as console:
        told = Told(console, page)
        told.state = under(LOCKED)
        told.until(
            "the settings", lambda: bool(console.intents) and present(console.intents[-1].intent).settings == LOCKED
        )
        assert shows_locked(page)
        assert CHANGED not in page.words("#alert")
        page.close()


def test_the_settings_of_a_new_lease_are_shown_and_the_operator_is_told(told: Told) -> None:
    told.state = under(LOCKED)
    told.until("the lock", lambda: shows_locked(told.page))
    told.state = under(OperatorSettings(lease=LEASE + 1))
    told.until("the word", lambda: CHANGED in told.page.words("#alert"))
    assert told.page.words("#scale-value") == "1.00"
    assert told.page.page.get_attribute("[data-lock=z]", "aria-pressed") == "false"


@pytest.mark.slow
def test_a_closed_page_falls_silent_and_stays_so(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, console.address)
        page.wait_for("intents", lambda: bool(console.intents) and console.intents[-1].intent is not None)
        page.close()

        def silent() -> bool:
            sent = len(console.intents)
            time.sleep(0.3)
            return len(console.intents) == sent and console.intents[-1].intent is None

        # No other page watches: where this one stood still for a moment, the other would have taken the controls.
        assert any(silent() for _ in range(SILENCES)), console.intents[-1]


@pytest.mark.slow
def test_a_slider_with_the_focus_shows_the_scale_of_a_new_lease(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, console.address)
        told = Told(console, page)
        told.state = under(LOCKED)
        told.until("the lock", lambda: shows_locked(page))
        page.page.focus("#scale")
        told.state = under(OperatorSettings(lease=LEASE + 1))
        told.until("the defaults", lambda: page.words("#scale-value") == "1.00")
        told.until("the slider", lambda: page.page.input_value("#scale") == "1")
        page.close()
