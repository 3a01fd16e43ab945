"""H.264 in the browser: painted as it comes, nothing after a gap until a key frame, and what a page without it does."""

from dataclasses import replace

import pytest

from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from lab.measure.page.painted_clock import ages_ms, compare, watch
from tests.browser.h264_scene import FULL, H264Cameras
from tests.browser.opened_page import OpenedPage
from tests.browser.told import Told

KEEP_PAINTED = """async () => {
  window.paintedFrames = {};
  const { PictureVideo } = await import("/static/picture_video.js");
  const paint = PictureVideo.prototype.paint;
  PictureVideo.prototype.paint = function (picture) {
    const name = this.element.closest(".view").dataset.name;
    const isH264 = picture.timestamp > 0; // of a JPEG it is 0
    if (isH264) window.paintedFrames[name] = (window.paintedFrames[name] ?? 0) + 1;
    paint.call(this, picture);
  };
}"""


def painted(told: Told) -> dict[str, int]:
    """How many H.264 pictures each view has painted."""
    return dict(told.page.page.evaluate("window.paintedFrames"))


@pytest.fixture
def cameras(told: Told) -> H264Cameras:
    """Four cameras that send H.264 to the page, which has painted some of each."""
    cameras = H264Cameras(told.key_frames)
    told.until("a page that decodes H.264", lambda: bool(told.shown) and told.shown[-1].h264)
    told.page.page.evaluate(KEEP_PAINTED)
    told.picture = cameras.picture
    told.until("H.264 in every view", lambda: set(painted(told)) == set(scene.CAMERAS))
    return cameras


@pytest.mark.slow
def test_h264_is_painted_live_and_shows_what_was_sent(told: Told, cameras: H264Cameras) -> None:
    clock = compare(told.page.page)
    watch(told.page.page)
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    told.until("the pictures", lambda: bool(told.page.page.evaluate("window.paintedClocks.length > 40")))
    ages = ages_ms(told.page.page, clock)
    assert set(ages) == set(scene.CAMERAS)
    assert all(len(of_view) > 5 for of_view in ages.values())
    assert not cameras.loses
    told.shot("h264")


@pytest.mark.slow
def test_a_gap_shows_the_last_whole_picture_as_old_until_the_key_frame(told: Told, cameras: H264Cameras) -> None:
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    cameras.answers = False
    cameras.loses = {"side"}
    told.until("a gap", lambda: told.mark("side") == "old")
    cameras.loses = set()
    asked, before = len(told.key_frames), painted(told)
    told.until("requests that are repeated", lambda: len(told.key_frames) >= asked + 3)
    assert {request.camera for request in told.key_frames[asked:]} == {"side"}
    assert painted(told)["side"] == before["side"]
    assert painted(told)["gripper"] > before["gripper"]
    told.until("the age", lambda: "s old" in told.page.words("[data-name=side] .mark"))
    cameras.answers = True
    told.until("the view", lambda: told.mark("side") == "live")
    assert painted(told)["side"] > before["side"]


@pytest.mark.slow
def test_bytes_that_are_no_picture_cost_one_view_its_pictures_until_a_key_frame(
    told: Told, cameras: H264Cameras
) -> None:
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    asked = len(told.key_frames)
    cameras.spoils = {"side"}
    told.until("a request", lambda: len(told.key_frames) > asked)  # a slow page also marks pictures as old
    told.until("an old picture", lambda: told.mark("side") == "old" and told.mark("gripper") == "live")
    assert {request.camera for request in told.key_frames[asked:]} == {"side"}
    cameras.spoils = set()
    told.until("the view", lambda: told.mark("side") == "live")


def test_another_size_and_jpeg_between_are_painted_too(told: Told, cameras: H264Cameras) -> None:
    width = "() => document.querySelector('[data-name=side] .picture').videoWidth"
    cameras.setting = replace(FULL, scale=0.5)
    told.until("smaller pictures", lambda: told.page.page.evaluate(width) == scene.SIZE[1] // 2)
    told.reset()
    told.until("JPEG", lambda: told.page.page.evaluate(width) == scene.SIZE[1])
    before = painted(told)
    told.picture = cameras.picture
    told.until("H.264", lambda: painted(told)["side"] > before["side"] + 3)
    assert told.page.page.evaluate(width) == scene.SIZE[1] // 2


@pytest.mark.slow
def test_a_page_without_a_decoder_says_so_asks_for_no_key_frames_and_paints_jpeg(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, "about:blank")
        page.context.add_init_script("delete window.VideoDecoder")
        page.page.goto(console.address)
        told = Told(console, page)
        told.describe()
        told.until("a report", lambda: bool(console.shown) and "live" in page.marks())
        assert not console.shown[-1].h264
        told.picture = H264Cameras(console.key_frames).picture
        told.until("the sentence", lambda: "cannot decode H.264" in page.words("[data-name=side] .mark"))
        asked = len(console.key_frames)
        for _ in range(20):
            told.tell()
            page.page.wait_for_timeout(20)
        assert len(console.key_frames) == asked
        told.reset()
        told.until("JPEG again", lambda: "cannot decode" not in page.words("[data-name=side] .mark"))
        told.until("a live view", lambda: told.mark("side") == "live")
        page.close()
