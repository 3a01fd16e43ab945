"""On what a view shows its pictures: on a video where the browser can, else, or where that is stuck, on a canvas."""

from collections.abc import Iterator

import pytest

from common.messages.video import CameraStatus
from lab.measure.page import scene
from tests.browser.told import Told, opened_told

SIZES = """() => ((canvas) => [canvas.width, canvas.height, canvas.clientWidth, canvas.clientHeight])
    (document.querySelector('#cameras canvas.picture'))"""
SURFACE = "document.querySelector('[data-name=side] .picture')"


@pytest.fixture
def on_canvas(browser: object) -> Iterator[Told]:
    """A page in a browser that makes no video of single pictures, as Firefox and Safari."""
    with opened_told(browser, "delete window.MediaStreamTrackGenerator") as told:
        yield told


def test_on_a_canvas_a_picture_has_no_more_pixels_than_the_screen_shows_of_it(on_canvas: Told) -> None:
    told, page = on_canvas, on_canvas.page.page
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    told.until("fewer pixels", lambda: page.evaluate(SIZES)[0] < scene.SIZE[1])  # four views on 1280 x 720
    width, height, shown_width, shown_height = page.evaluate(SIZES)
    assert min(shown_width / width, shown_height / height) == pytest.approx(1.0, abs=0.01)
    assert width / height == pytest.approx(scene.SIZE[1] / scene.SIZE[0], abs=0.01)
    page.keyboard.press("1")
    told.until("all pixels", lambda: page.evaluate(SIZES)[:2] == [scene.SIZE[1], scene.SIZE[0]])
    page.keyboard.press("1")
    told.until("fewer again", lambda: page.evaluate(SIZES)[0] == width)


def test_on_a_canvas_too_a_view_of_the_operator_that_is_missing_keeps_no_old_picture(on_canvas: Told) -> None:
    told = on_canvas
    pixel = "() => [...document.querySelector('#previews canvas').getContext('2d').getImageData(9, 9, 1, 1).data]"
    told.previews = ("left",)
    told.until("a picture", lambda: "live" in told.page.words("#previews"))
    assert told.page.page.evaluate(pixel)[0] > 100
    told.troubles = dict.fromkeys(told.previews, (CameraStatus.MISSING, "no camera is used"))
    told.until("none", lambda: "no picture" in told.page.words("#previews"))
    assert told.page.page.evaluate(pixel)[0] == 0


@pytest.fixture
def fresh(browser: object) -> Iterator[Told]:
    """A page of this test alone, whose views may be spoilt."""
    with opened_told(browser) as told:
        yield told


def test_a_video_that_the_browser_pauses_gives_way_to_a_canvas(fresh: Told) -> None:
    """Its picture would stand still and be marked as a live one."""
    told = fresh
    page = told.page.page
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    assert page.evaluate(f"{SURFACE}.tagName") == "VIDEO"
    page.evaluate(f"{SURFACE}.pause()")
    told.until("no live view", lambda: told.mark("side") == "none")
    told.until("a canvas", lambda: page.evaluate(f"{SURFACE}.tagName") == "CANVAS")
    told.until("a live view on it", lambda: told.mark("side") == "live" and page.evaluate(f"{SURFACE}.width") > 300)
    told.until("others on a video", lambda: page.evaluate("document.querySelectorAll('#cameras video').length") == 3)
