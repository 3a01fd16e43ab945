"""Accessibility of the page: contrast in dark and light, names, sizes, and everything reached by keyboard alone."""

from functools import partial
from pathlib import Path

import pytest

from tests.browser.told import Told

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
SCREENS = {"dark": ("dark", 1280, 720), "light": ("light", 1280, 720), "tablet": ("light", 820, 1180)}


@pytest.mark.slow
@pytest.mark.parametrize("screen", SCREENS)
def test_words_stand_out_and_everything_has_a_name_and_room_for_a_finger(told: Told, screen: str) -> None:
    scheme, width, height = SCREENS[screen]
    page = told.page.page
    told.page.wear(scheme)
    told.page.resize(width, height)
    told.state = partial(told.state, traced=told.traced(4710))
    told.until("the trace", lambda: "encoder" in told.page.words("#trace"))
    page.keyboard.press("Escape")
    told.until("the acknowledgement", lambda: "acknowledged" in told.page.words("#alert"))
    found = page.evaluate(CHECK)
    told.shot(screen)
    told.page.resize(1280, 720)
    assert found["poor"] == []
    assert found["nameless"] == []
    assert found["small"] == []
    assert not found["wide"]
    assert (found["language"], found["headings"]) == ("en", 1)


def test_every_control_is_reached_by_tab_with_the_stop_first(told: Told) -> None:
    page = told.page.page
    told.until("the controls", lambda: "you operate" in told.page.words("#seat") and page.is_visible("#hold"))
    page.evaluate("() => { const top = document.querySelector('header'); top.tabIndex = -1; top.focus(); }")
    reached: list[str] = []
    for _ in range(40):
        page.keyboard.press("Tab")
        focused = page.evaluate(
            "() => { const e = document.activeElement; return e.id || e.dataset.lock || e.dataset.name || e.tagName; }"
        )
        if focused in ("BODY", *reached):
            break
        reached.append(focused)
    cameras = ["front_high", "front_low", "side", "gripper"]
    wanted = ["stop", "type", "tones", "theme", *cameras, "hold", "disengage", "clutch", "origins", "seat-button"]
    wanted += ["arm", "ghost", "marks", "scale", "rotation", "x", "y", "z", "roll", "pitch", "yaw"]
    assert [name for name in reached if name in wanted] == wanted
