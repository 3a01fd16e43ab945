"""The page on a telephone held upright, live and in replay: nothing overlaps, is cut off or lies beyond its side."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import pytest

import tests.common.messages.golden_examples as golden
from common.messages.robot import SessionState
from common.messages.video import CameraStatus
from lab.measure.page import scene
from tests.browser.opened_page import OpenedPage
from tests.browser.replayed import jump, served
from tests.browser.told import SHOTS, Told, opened_told

CHECK = (Path(__file__).parent / "layout.js").read_text().split("\n", 1)[1]
WIDTH, HEIGHT = 390, 844
REASON = "disengaged, the newest hand sample is 310 ms old (limit 150 ms); engage again to continue"
NO_CAMERA = "no camera is used: a recorded path is run, episode 12 of 20260304T050607Z_cell_001.mcap"
MISSING = "camera {} has given no new picture for 0.6 s; check its cable, its power and its address"


@pytest.fixture(scope="module")
def told_here(browser: object) -> Iterator[Told]:
    """A page of its own: it sees more of the operator than others expect."""
    with opened_told(browser) as told:
        told.page.resize(WIDTH, HEIGHT)
        yield told


@pytest.fixture
def narrow(told_here: Told) -> Told:
    """The page with all that it can show at once."""
    told = told_here
    told.reset()
    recording = msgspec.structs.replace(golden.RECORDING, writing=True, on_request=True, operator_pictures=True, lost=3)
    known = {"recording": recording, "assist": golden.STATE.assist}
    told.state = partial(scene.state, SessionState.DISENGAGED, "latched", REASON, **known)
    told.previews = ("left", "right")
    told.page.page.evaluate("() => scrollTo(0, 0)")
    return told


def check(page: OpenedPage) -> None:
    found = page.page.evaluate(CHECK)
    assert found == {"width": WIDTH, "outside": [], "cut": [], "thin": [], "overlapping": []}


@pytest.mark.slow
def test_a_live_page_is_whole(narrow: Told) -> None:
    narrow.until("all of it", lambda: narrow.page.words("#recording").startswith("REC, with the operator's pictures"))
    check(narrow.page)
    narrow.shot("narrow")
    narrow.page.page.keyboard.press("Escape")
    narrow.until("the acknowledgement", lambda: "acknowledged" in narrow.page.words("#alert"))
    check(narrow.page)
    assert narrow.page.page.is_visible("#stop")


def test_a_live_page_in_large_type_has_nothing_over_another(narrow: Told) -> None:
    narrow.page.page.keyboard.press("l")
    narrow.until("all of it", lambda: narrow.page.words("#recording").startswith("REC, with the operator's pictures"))
    found = narrow.page.page.evaluate(CHECK)
    narrow.shot("narrow_large")
    narrow.page.page.keyboard.press("l")
    assert (found["width"], found["outside"], found["thin"], found["overlapping"]) == (WIDTH, [], [], [])


def is_pressed(told: Told, finger: Any) -> bool:
    """Put a finger on the key, where it is now, and say whether it counts; a busy page may hide it in between."""
    page = told.page.page
    page.evaluate("() => document.getElementById('hold').scrollIntoView({ block: 'center' })")
    box = page.locator("#hold").bounding_box()
    if box is None:
        return False
    at = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [at]})
    page.wait_for_timeout(100)
    if page.get_attribute("#hold", "aria-pressed") == "true":
        return True
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    return False


def test_a_finger_enlarges_a_view_stops_the_arm_and_holds_the_key(narrow: Told) -> None:
    page = narrow.page.page
    page.tap("[data-name=side]")
    assert page.get_attribute("[data-name=side]", "class") == "view enlarged"
    page.tap("[data-name=side]")
    assert page.get_attribute("[data-name=side]", "class") == "view"
    finger = page.context.new_cdp_session(page)
    narrow.until("the press", lambda: is_pressed(narrow, finger))
    narrow.until("the hold", lambda: narrow.intents[-1].intent is not None and narrow.intents[-1].intent.hold)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    narrow.until("its end", lambda: narrow.intents[-1].intent is not None and not narrow.intents[-1].intent.hold)
    page.tap("#stop")
    narrow.until("the acknowledgement", lambda: "acknowledged" in narrow.page.words("#alert"))


@pytest.mark.slow
def test_a_live_page_without_pictures_and_with_an_enlarged_one_is_whole(narrow: Told) -> None:
    narrow.troubles = {"side": (CameraStatus.FROZEN, MISSING)}
    narrow.until("the trouble", lambda: narrow.mark("side") == "frozen")
    narrow.page.page.keyboard.press("1")
    narrow.tell()
    check(narrow.page)
    narrow.shot("narrow_enlarged")
    narrow.page.page.keyboard.press("1")
    narrow.troubles = {}
    narrow.until("the picture", lambda: narrow.mark("side") == "live")


def test_a_live_page_that_says_why_there_is_no_view_of_the_operator_is_whole(narrow: Told) -> None:
    narrow.troubles = dict.fromkeys(narrow.previews, (CameraStatus.MISSING, NO_CAMERA))
    narrow.until("the words", lambda: NO_CAMERA in narrow.page.words("#previews"))
    check(narrow.page)
    narrow.page.page.evaluate("() => document.getElementById('previews').scrollIntoView({ block: 'center' })")
    narrow.shot("narrow_no_camera")


@pytest.mark.slow
def test_a_replay_is_whole_with_its_list_open_too(browser: object, tmp_path: Path) -> None:
    with served(browser, tmp_path) as shown:
        page = shown.page
        page.resize(WIDTH, HEIGHT)
        jump(page, 4.0)
        page.wait_for("a picture", lambda: "recorded" in page.words("#cameras"))
        check(page)
        page.page.click("summary")
        box = page.page.locator("#jumps").bounding_box()
        page.page.screenshot(path=str(SHOTS / "narrow_replay.png"))
        assert box is not None
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= WIDTH
        assert page.page.evaluate("() => document.documentElement.scrollWidth") == WIDTH
