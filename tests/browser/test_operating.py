"""The page as an operator uses it: it shows what is, its key moves the arm, and every end of it stops the arm."""

import os
import re
import signal
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest

from common.messages.robot import SessionState
from tests.browser.conftest import Stand
from tests.browser.opened_page import READING_MS, OpenedPage
from tests.integration.sites import descendants
from tests.present import present

STOP_WITHIN_S = 30.0  # that it comes, not how soon, which a busy machine decides
ENDS_WITHIN_S = 10.0  # two where a machine has nothing else to do


def at_rest(stand: Stand) -> bool:
    commanded = [state.q_commanded for state in stand.sites.record.states[-10:]]
    return all(q == commanded[0] for q in commanded)


def stops(stand: Stand) -> None:
    """The arm is disengaged and comes to rest."""
    stand.sites.wait("the stop", lambda: stand.sites.is_in(SessionState.DISENGAGED), STOP_WITHIN_S)
    stand.sites.wait("rest", lambda: at_rest(stand), STOP_WITHIN_S)


def test_the_space_bar_moves_the_arm_and_the_pictures_and_letting_go_stops_both(stand: Stand, page: OpenedPage) -> None:
    page.wait_for_live_views()
    before, posture = page.pictures(), stand.sites.state.q
    page.hold(until=lambda: np.abs(np.subtract(stand.sites.state.q, posture)).max() > 0.05)
    page.hold(until=lambda: all(a != b for a, b in zip(before, page.pictures(), strict=True)))
    page.page.keyboard.up("Space")
    stops(stand)
    assert stand.sites.state.code == "let_go"
    page.wait_for("the page to say so", lambda: page.state() == "disengaged")
    assert "the key was let go" in page.words("#reason")
    events = page.page.locator("#events li")
    page.wait_for("the event", lambda: any("let go" in line for line in events.all_text_contents()))


@pytest.mark.slow
def test_freezing_the_tab_stops_the_arm_and_it_needs_a_new_press(stand: Stand, page: OpenedPage) -> None:
    page.hold()
    page.page.evaluate("() => { const until = performance.now() + 900; while (performance.now() < until); }")
    stops(stand)
    page.page.wait_for_timeout(400)
    assert page.page.get_attribute("#hold", "aria-pressed") == "true"
    assert stand.sites.is_in(SessionState.DISENGAGED)
    page.hold()


@pytest.mark.slow
def test_hiding_the_tab_lets_go(stand: Stand, page: OpenedPage) -> None:
    page.hold()
    page.page.evaluate("() => document.dispatchEvent(new Event('visibilitychange'))")
    stops(stand)


def test_escape_stops_the_arm_is_acknowledged_and_latches(stand: Stand, page: OpenedPage) -> None:
    page.hold()
    page.page.keyboard.press("Escape")
    stops(stand)
    page.wait_for("the acknowledgement", lambda: "acknowledged by the remote site" in page.words("#alert"))
    assert stand.sites.state.code == "stopped"
    page.wait_for("the page to say so", lambda: page.state() == "stopped")
    page.page.keyboard.up("Space")
    page.page.keyboard.press("e")
    page.page.keyboard.down("Space")
    page.page.wait_for_timeout(500)
    assert stand.sites.is_in(SessionState.DISENGAGED)
    page.page.keyboard.up("Space")
    page.page.wait_for_timeout(READING_MS)
    page.page.keyboard.press("r")
    page.hold()


@pytest.mark.slow
def test_a_second_page_only_stops_until_it_has_the_controls_and_its_end_stops_the_arm(
    stand: Stand, page: OpenedPage, open_page: Callable[[], OpenedPage]
) -> None:
    watching = open_page()
    page.wait_for("the controls", lambda: "you operate" in page.words("#seat"))
    number = re.findall(r"page (\d+)", page.words("#seat"))[0]
    watching.wait_for("the word", lambda: f"you watch; page {number} (127.0.0.1) operates" in watching.words("#seat"))
    assert watching.page.is_disabled("#engage")
    assert watching.page.is_disabled("#hold")
    watching.page.keyboard.down("Space")
    watching.page.wait_for_timeout(300)
    assert not stand.sites.state.readiness.held
    watching.page.click("#seat-button")
    watching.wait_for("the refusal", lambda: "has to leave the controls" in watching.words("#alert"))

    watching.page.click("#stop")
    page.wait_for("the stop", lambda: page.state() == "stopped")
    page.page.wait_for_timeout(READING_MS)
    page.page.click("#reset")
    page.wait_for("the reset", lambda: page.state() == "disengaged")

    page.page.click("#seat-button")
    watching.wait_for("an empty seat", lambda: "nobody operates" in watching.words("#seat"))
    watching.page.click("#seat-button")
    watching.wait_for("the controls", lambda: "you operate" in watching.words("#seat"))
    watching.hold()
    watching.page.close()
    stops(stand)
    page.wait_for("an empty seat again", lambda: "nobody operates" in page.words("#seat"))
    page.page.click("#seat-button")
    page.wait_for("the controls", lambda: "you operate" in page.words("#seat"))


@pytest.mark.slow
def test_scales_locks_and_new_origins_reach_the_arm_and_outlast_a_reload(stand: Stand, page: OpenedPage) -> None:
    page.wait_until_ready()
    in_force = lambda: present(stand.sites.state.settings)  # noqa: E731  # short, and used as such
    page.page.fill("#scale", "0.5")
    page.wait_for("the scale", lambda: in_force().scale == 0.5)
    page.page.click("[data-lock=roll]")
    page.wait_for("the lock", lambda: in_force().locks.roll)
    before = in_force()
    page.hold(until=lambda: page.page.is_visible("#origins"))
    page.page.keyboard.press("n")
    page.wait_for("new origins", lambda: in_force() == msgspec.structs.replace(before, revision=before.revision + 1))
    page.page.keyboard.up("Space")

    page.page.reload()
    page.wait_for("the controls", lambda: page.page.is_enabled("[data-lock=roll]"))
    assert page.page.get_attribute("[data-lock=roll]", "aria-pressed") == "true"
    assert page.words("#scale-value") == "0.50"
    assert in_force().locks.roll
    page.page.fill("#scale", "1")
    page.page.click("[data-lock=roll]")
    page.wait_for("both to be taken back", lambda: in_force().scale == 1.0 and not in_force().locks.roll)


def test_the_tool_is_drawn_where_it_is(stand: Stand, page: OpenedPage) -> None:
    page.wait_for("the arm", lambda: "tool at" in page.words("#arm-words"))

    def is_shown() -> bool:
        shown = [float(part) for part in page.words("#arm-words").split("tool at ")[1].split(" mm")[0].split(", ")]
        return shown == pytest.approx([1000 * v for v in stand.sites.state.base_T_tool.position], abs=1.0)

    page.wait_for("the tool where it is", is_shown)


def test_a_view_is_enlarged_by_its_number_and_made_small_again(page: OpenedPage) -> None:
    page.wait_for("the views", lambda: len(page.marks()) == 4)
    widths = "(views) => views.map((view) => view.clientWidth)"
    page.page.keyboard.press("3")
    enlarged = page.page.eval_on_selector_all("#cameras .view", widths)
    assert enlarged[2] > 2 * max(enlarged[0], enlarged[1], enlarged[3])
    page.page.keyboard.press("3")
    again = page.page.eval_on_selector_all("#cameras .view", widths)
    assert max(again) - min(again) <= 1


def test_the_page_tells_latency_and_the_clock(page: OpenedPage) -> None:
    page.wait_for("glass to glass", lambda: median_of(page, "picture") > 0)
    assert median_of(page, "round_trip") > 0
    assert median_of(page, "uncertainty") < 1000


def median_of(page: OpenedPage, interval: str) -> float:
    told = page.words(f"[data-interval={interval}] td:nth-of-type(2)")
    return float(told) if told not in ("", "–") else -1.0


@pytest.mark.slow
def test_pictures_that_stop_coming_are_marked_with_their_age(stand: Stand, page: OpenedPage) -> None:
    page.wait_for_live_views()
    video = next(p for p in descendants(stand.remote.pid) if Path(f"/proc/{p}/comm").read_text() == "farhand-video\n")
    os.kill(video, signal.SIGSTOP)
    try:
        page.wait_for("the marks", lambda: page.marks() == ["old"] * 4)
        page.wait_for("the age", lambda: " s old" in page.words("#cameras .mark b"))
    finally:
        os.kill(video, signal.SIGCONT)
    page.wait_for_live_views()


@pytest.mark.slow
def test_a_killed_remote_site_is_told_and_its_pictures_marked_and_the_console_ends_when_asked(
    stand: Stand, page: OpenedPage
) -> None:
    page.wait_for_live_views()
    for process in (*descendants(stand.remote.pid), stand.remote.pid):
        os.kill(process, signal.SIGKILL)
    page.wait_for("the word", lambda: page.state() == "silent")
    page.wait_for("the marks", lambda: page.marks() == ["old"] * 4)
    assert "the remote site has been silent" in page.words("#reason")
    page.page.keyboard.press("Escape")
    page.wait_for("the truth about the stop", lambda: "NOT ACKNOWLEDGED" in page.words("#alert"))

    os.kill(stand.console.pid, signal.SIGTERM)
    stand.sites.wait("the console's end", lambda: stand.console.exit_code is not None, ENDS_WITHIN_S)
    assert stand.console.exit_code == 0
    page.wait_for("the page to say so", lambda: page.state() == "no connection")
    page.page.goto("about:blank")  # the page would keep trying to connect
    page.errors.clear()  # the browser itself reports that the connection is lost
