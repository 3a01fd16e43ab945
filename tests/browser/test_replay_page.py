"""A recording on the page: it says so everywhere, plays, jumps, and offers nothing that a robot would do."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

import tests.common.messages.golden_examples as golden
from common.messages.hand import OperatorSettings
from common.messages.robot import Readiness, VideoLink
from tests.browser.opened_page import OpenedPage
from tests.browser.replayed import jump, served
from tests.browser.told import SHOTS
from tests.farhand.replay.recorded_states import ENGAGED_S, SECONDS
from tests.present import present

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
LET_GO = "let go of the key first, then press it: what has ended never resumes by itself"
OF_A_LIVE_CELL = re.compile("check them|free some space|the held key|NOT ACKNOWLEDGED")


@pytest.fixture(scope="module")
def replay(browser: object, tmp_path_factory: pytest.TempPathFactory) -> Iterator[OpenedPage]:
    """A page of a replay."""
    with served(browser, tmp_path_factory.mktemp("replay")) as shown:
        yield shown.page


def instructed(at_s: float) -> dict[str, Any]:
    """What an operator was told to do: before the engagement, and later by a recorder, a link and other settings."""
    to_do = Readiness(False, "let_go_first", LET_GO, True)
    stopped = {"code": "stopped", "reason": "stopped by anna; reset it, then engage", "readiness": to_do}
    said = stopped if at_s < ENGAGED_S else {}
    alarm = msgspec.structs.replace(golden.RECORDING, alarm="recording has ended: free some space, and start it again")
    narrow = VideoLink(carries_mbit_s=3.5, needs_mbit_s=20.0, reason="the link carries 3.5 Mbit/s. Cure: a wider link")
    late = msgspec.structs.replace(
        present(golden.STATE.hand_link), code="samples_old", reason="too old: network 240 ms"
    )
    settings = OperatorSettings(lease=5 if at_s < ENGAGED_S else 6, scale=1.0 if at_s < ENGAGED_S else 0.5)
    return said | {"recording": alarm, "video_link": narrow, "hand_link": late, "settings": settings}


@pytest.mark.slow
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


@pytest.mark.slow
def test_it_plays_and_pauses(replay: OpenedPage) -> None:
    jump(replay, 0.2, playing=True)
    replay.wait_for("the time to go on", lambda: replay.words("#position") > "0:00.8")
    jump(replay, 1.0)
    replay.wait_for("the jump", lambda: replay.words("#position").startswith("0:01.0"))
    replay.page.wait_for_timeout(500)
    assert replay.words("#position").startswith("0:01.0")


@pytest.mark.slow
def test_the_space_bar_plays_and_pauses_whatever_has_the_focus(replay: OpenedPage) -> None:
    jump(replay, 1.0)
    theme = replay.page.get_attribute("html", "data-theme")
    for focused in ("#theme", "#timeline", "#play"):
        replay.page.focus(focused)
        for word in ("Pause", "Play"):
            replay.page.keyboard.press("Space")
            replay.wait_for("the button", lambda: replay.words("#play-word") == word)  # noqa: B023  # in this round
    assert replay.page.get_attribute("html", "data-theme") == theme


TICKS = """() => {
  const track = document.getElementById("timeline").getBoundingClientRect();
  return [...document.querySelectorAll("#ticks span")].map((tick) => {
    const { left, width, height } = tick.getBoundingClientRect();
    return [(left + width / 2 - track.left - 8) / (track.width - 16), height];
  });
}"""


def test_the_timeline_has_a_mark_where_something_happened(replay: OpenedPage) -> None:
    listed = replay.page.locator("#jumps button").all_text_contents()
    ticks = replay.page.evaluate(TICKS)
    assert len(ticks) == len(listed) >= 2
    times = [60 * int(minutes) + float(seconds) for minutes, seconds in (line.split()[0].split(":") for line in listed)]
    assert [part * SECONDS for part, _ in ticks] == pytest.approx(times, abs=0.25)
    assert min(height for _, height in ticks) >= 5
    assert any(abs(at_s - ENGAGED_S) < 0.2 for at_s in times)


def test_the_list_has_nothing_of_what_only_comes_and_goes(replay: OpenedPage) -> None:
    words = " ".join(replay.page.locator("#jumps button").all_text_contents())
    assert "engaged: the arm follows" in words
    for noise in ("starting", "not engaged yet", "singular", "(ok)"):
        assert noise not in words


def test_a_rate_is_only_told_while_it_plays(replay: OpenedPage) -> None:
    jump(replay, 3.0)
    replay.wait_for("no rate", lambda: "recorded" in replay.words("#cameras") and "fps" not in replay.words("#cameras"))
    jump(replay, 2.0, playing=True)
    replay.wait_for("a rate", lambda: "fps" in replay.words("#cameras"))
    jump(replay, 1.0)


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


@pytest.mark.slow
def test_what_was_said_is_quoted_and_what_concerns_a_live_cell_alone_is_gone(browser: object, tmp_path: Path) -> None:
    with served(browser, tmp_path, instructed) as shown:
        page = shown.page
        for seconds, state, told in ((1.0, "disengaged", "stopped by anna"), (4.0, "engaged", "the arm follows")):
            jump(page, seconds)
            page.wait_for("the state", lambda: page.state() == state)  # noqa: B023  # called in this round
            page.wait_for("its reason", lambda: page.words("#reason").startswith(told))  # noqa: B023
            assert page.words("#reason").endswith("too old: network 240 ms")
            assert quotes(page) == ['"then: “"', '"”"']
            assert OF_A_LIVE_CELL.findall(page.page.inner_text("body")) == []
        shown.end()
        page.wait_for("the end", lambda: page.words("#reason") == "the program that replays does not answer")
        assert quotes(page) == ["none", "none"]
        assert OF_A_LIVE_CELL.findall(page.page.inner_text("body")) == []


def quotes(page: OpenedPage) -> list[str]:
    """What stands before and behind the reason."""
    read = "side => getComputedStyle(document.getElementById('reason'), side).content"
    return [page.page.evaluate(read, side) for side in ("::before", "::after")]


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_its_words_stand_out_and_everything_has_a_name(replay: OpenedPage, scheme: str) -> None:
    replay.wear(scheme)
    found = replay.page.evaluate(CHECK)
    assert found["poor"] == []
    assert found["nameless"] == []
    assert found["small"] == []
    assert not found["wide"]
