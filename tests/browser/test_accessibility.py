"""The page for everybody: contrast in dark and light, names, sizes, and everything reached by keyboard alone."""

from pathlib import Path

import pytest
from opened_page import OpenedPage

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
SCREENS = {
    "dark": {"color_scheme": "dark"},
    "light": {"color_scheme": "light"},
    "tablet": {"color_scheme": "light", "viewport": {"width": 820, "height": 1180}, "has_touch": True},
}
SHOTS = Path("build") / "screenshots"


@pytest.mark.parametrize("screen", SCREENS)
def test_words_stand_out_and_everything_has_a_name_and_room_for_a_finger(stand, screen: str) -> None:
    page = OpenedPage(stand.browser, stand.address, **SCREENS[screen])
    page.wait_for("the pictures", lambda: page.marks() == ["live"] * 4)
    page.page.keyboard.press("Escape")
    page.wait_for("the stop", lambda: page.state() == "stopped")
    found = page.page.evaluate(CHECK)
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.page.screenshot(path=str(SHOTS / f"{screen}.png"))
    page.page.keyboard.press("r")
    page.wait_for("the reset", lambda: page.state() != "stopped")
    page.close()
    assert found["poor"] == []
    assert found["nameless"] == []
    assert found["small"] == []
    assert not found["wide"]
    assert (found["language"], found["headings"]) == ("en", 1)


def test_every_control_is_reached_by_tab_with_the_stop_first(stand) -> None:
    page = OpenedPage(stand.browser, stand.address)
    page.wait_for("the controls", lambda: "you operate" in page.words("#seat") and len(page.marks()) == 4)
    reached = []
    for _ in range(40):
        page.page.keyboard.press("Tab")
        focused = page.page.evaluate(
            "() => { const e = document.activeElement; return e.id || e.dataset.lock || e.dataset.name || e.tagName; }"
        )
        if focused == "BODY":
            break
        reached.append(focused)
    page.close()
    cameras = ["front_high", "front_low", "side", "gripper"]
    wanted = ["stop", *cameras, "arm", "seat-button", "hold", "engage", "disengage", "reset", "clutch"]
    wanted += ["scale", "rotation", "x", "y", "z", "roll", "pitch", "yaw", "events"]
    assert [name for name in reached if name in wanted] == wanted
    assert len(set(reached)) == len(reached)
