"""The page for everybody: contrast in dark and light, names, sizes, and everything reached by keyboard alone."""

from pathlib import Path

import pytest
from opened_page import OpenedPage

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
SCREENS = {"dark": ("dark", 1280, 720), "light": ("light", 1280, 720), "tablet": ("light", 820, 1180)}
SHOTS = Path(__file__).parents[2] / "build" / "screenshots"


@pytest.mark.parametrize("screen", SCREENS)
def test_words_stand_out_and_everything_has_a_name_and_room_for_a_finger(page: OpenedPage, screen: str) -> None:
    scheme, width, height = SCREENS[screen]
    page.page.emulate_media(color_scheme=scheme)
    page.page.set_viewport_size({"width": width, "height": height})
    page.wait_for_live_views()
    page.page.keyboard.press("Escape")
    page.wait_for("the stop", lambda: page.state() == "stopped")
    found = page.page.evaluate(CHECK)
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.page.screenshot(path=str(SHOTS / f"{screen}.png"))
    page.page.set_viewport_size({"width": 1280, "height": 720})
    assert found["poor"] == []
    assert found["nameless"] == []
    assert found["small"] == []
    assert not found["wide"]
    assert (found["language"], found["headings"]) == ("en", 1)


def test_every_control_is_reached_by_tab_with_the_stop_first(page: OpenedPage) -> None:
    page.wait_for("the views", lambda: len(page.marks()) == 4)
    page.page.evaluate("() => document.activeElement.blur()")
    reached = []
    for _ in range(40):
        page.page.keyboard.press("Tab")
        focused = page.page.evaluate(
            "() => { const e = document.activeElement; return e.id || e.dataset.lock || e.dataset.name || e.tagName; }"
        )
        if focused in ("BODY", *reached):
            break
        reached.append(focused)
    cameras = ["front_high", "front_low", "side", "gripper"]
    wanted = ["stop", *cameras, "arm", "seat-button", "hold", "engage", "disengage", "reset", "clutch"]
    wanted += ["scale", "rotation", "x", "y", "z", "roll", "pitch", "yaw", "events"]
    assert [name for name in reached if name in wanted] == wanted
