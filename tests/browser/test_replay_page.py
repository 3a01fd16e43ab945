"""A recording on the page: it says so everywhere, plays, jumps, and offers nothing that a robot would do."""

import asyncio
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from farhand.replay.console import serve_replay
from farhand.replay.recorded_scene import RecordedScene
from local_site.console.config import ServeConfig
from tests.browser.opened_page import OpenedPage
from tests.farhand.replay.recorded_states import SECONDS, recorded_states

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
SHOTS = Path(__file__).parents[2] / "build" / "screenshots"
START_S = 30.0


@pytest.fixture(scope="module")
def replay(browser: object, tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpenedPage]:
    """A page of a replay."""
    folder = tmp_path_factory.mktemp("replay")
    recorded = recorded_states(folder)
    heard = SimpleNamespace(address="", ended=False, ready=threading.Event())

    def announce(words: str) -> None:
        heard.address = words.rpartition(" ")[2]
        heard.ready.set()

    def serve() -> None:
        with RecordedScene(recorded.file, folder) as scene:
            asyncio.run(serve_replay(scene, "a recording", ServeConfig(port=0), lambda: heard.ended, announce))

    thread = threading.Thread(target=serve, name="replay", daemon=True)
    thread.start()
    assert heard.ready.wait(START_S)
    page = OpenedPage(browser, heard.address)
    page.wait_for("the timeline", lambda: "/ 0:0" in page.words("#position"))
    yield page
    page.close()
    heard.ended = True
    thread.join(START_S)
    assert not [error for error in page.errors if "WebSocket" not in error]


def jump(page: OpenedPage, seconds: float, *, playing: bool = False) -> None:
    """Pause, or play, from a time on."""
    if (page.words("#play") == "Pause") is not playing:
        page.page.click("#play")
        page.wait_for("the button", lambda: (page.words("#play") == "Pause") is playing)
    page.page.fill("#timeline", str(seconds))


def test_it_cannot_be_mistaken_for_a_live_page(replay: OpenedPage) -> None:
    jump(replay, 4.0)
    replay.wait_for("the state", lambda: replay.state() == "engaged")
    replay.wait_for("a picture", lambda: "recorded" in replay.words("#cameras"))
    SHOTS.mkdir(parents=True, exist_ok=True)
    replay.page.screenshot(path=str(SHOTS / "replay.png"))
    assert replay.words("#replay-mark").startswith("REPLAY a recording, recorded 2026-03-04")
    assert replay.page.is_visible("#replay-mark")
    assert replay.page.title() == "REPLAY a recording"
    assert "live" not in replay.words("#cameras")
    for control in ("#stop", "#controls", "#hold", "#engage"):
        assert not replay.page.is_visible(control)


def test_it_plays_and_pauses(replay: OpenedPage) -> None:
    jump(replay, 0.2, playing=True)
    replay.wait_for("the time to go on", lambda: replay.words("#position") > "0:00.8")
    jump(replay, 1.0)
    replay.wait_for("the jump", lambda: replay.words("#position").startswith("0:01.0"))
    replay.page.wait_for_timeout(500)
    assert replay.words("#position").startswith("0:01.0")


def test_events_and_keys_lead_through_it(replay: OpenedPage) -> None:
    jump(replay, 0.0)
    replay.page.click("summary")
    replay.page.click("#jumps button:text-matches('[0-9] engaged')")
    replay.page.click("summary")
    replay.wait_for("the engagement", lambda: replay.words("#position").startswith("0:02."))
    replay.page.evaluate("() => document.activeElement.blur()")
    replay.page.keyboard.press("ArrowRight")
    replay.wait_for("five seconds later, or the end", lambda: replay.words("#position") > f"0:0{SECONDS - 0.2:.1f}")
    replay.page.keyboard.press("ArrowLeft")
    replay.wait_for("back", lambda: replay.words("#position").startswith(("0:00.", "0:01.")))
    assert replay.state() == "disengaged"


def test_a_stop_is_answered_with_what_to_use_instead(replay: OpenedPage) -> None:
    replay.page.keyboard.press("Escape")
    replay.wait_for("the answer", lambda: "This is a replay, no robot is connected" in replay.words("#alert"))
    assert "emergency stop" in replay.words("#alert")
    assert "NOT ACKNOWLEDGED" not in replay.words("#alert")


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_its_words_stand_out_and_everything_has_a_name(replay: OpenedPage, scheme: str) -> None:
    replay.page.emulate_media(color_scheme=scheme)
    found = replay.page.evaluate(CHECK)
    assert found["poor"] == []
    assert found["nameless"] == []
    assert found["small"] == []
    assert not found["wide"]
