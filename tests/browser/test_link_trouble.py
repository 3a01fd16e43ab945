"""The page says what is wrong with the links: beside the state, in figures among the facts, and as an event."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest
from msgspec.structs import replace

from common.clock import NS_PER_S
from common.messages.robot import NO_PAGE, HandLink, Readiness, SessionState, VideoLink, VideoTrouble
from lab.measure.page import scene
from remote_site.reasons import Code, reason
from remote_site.session.hand_link_verdict import CURES
from tests.browser.told import Told

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
STALE = "newest hand sample is 320 ms old (limit 100 ms)"
PARTS = {"network_ms": 240.0, "clock_ms": 40.0, "tracking_ms": 30.0}
OLD = reason(
    Code.SAMPLES_OLD, age_ms=310.0, interval_ms=33.0, limit_ms=100.0, cure=CURES["unsteady network"], **PARTS
).sentence
SAID = "hand samples are too old: a sample each 33 ms, 310 ms old at arrival (limit 100 ms)"
CURE = "if the control endpoint is tls/, write it as quic/ at both sites, so that no sample waits for a lost packet."
NARROW = "the link carries 1.8 Mbit/s of pictures; the four views need about 31 Mbit/s"
LINK = HandLink(
    age_ms=310.0,
    network_ms=240.0,
    clock_ms=40.0,
    tracking_ms=30.0,
    interval_ms=33.0,
    jitter_ms=4.4,
    loss=0.012,
    code="samples_old",
    reason=OLD,
)


@pytest.fixture
def apart(told: Told) -> Iterator[Told]:
    """Two machines: their clocks have begun at other times."""
    clock, one = told.clock, told.clock.offset_ns
    clock.offset_ns = -50 * NS_PER_S
    yield told
    clock.offset_ns = one


@pytest.mark.slow
def test_a_links_trouble_is_told_with_its_figures(apart: Told) -> None:
    told = apart
    video = VideoLink(carries_mbit_s=1.8, needs_mbit_s=31.0, reason=NARROW)
    told.state = partial(scene.state, SessionState.HOLDING, "stale", STALE, hand_link=LINK, video_link=video)
    told.until("the reason", lambda: told.page.words("#reason") == SAID)
    told.until("the cure", lambda: told.page.words("#step-words").endswith(f"If it goes on holding: {CURE}"))
    assert told.page.page.evaluate("document.querySelector('#reason').scrollHeight <= reason.clientHeight")
    trouble = "pictures are sent smaller or fewer: the link is too narrow (1.8 of 31 Mbit/s)"
    told.until("the pictures' own", lambda: told.page.page.inner_text("[data-name=front_high] .trouble") == trouble)
    assert [told.page.words(f"[data-name={name}] .trouble") for name in scene.CAMERAS[1:]] == ["", "", ""]
    limit = "obeyed up to 100 ms, at 100 % of the speed"
    figures = f"310 ms old: network 240, clocks 40, tracking 30; jitter 4, loss 1.2 %; {limit}"
    told.until("the figures", lambda: told.page.words("#link") == figures)
    events = told.page.page.locator("#events li[data-kind=link]")
    told.until("the events", lambda: all(said in " ".join(events.all_text_contents()) for said in (OLD, NARROW)))
    told.shot("link trouble")
    assert told.page.page.evaluate(CHECK)["poor"] == []

    unknown = replace(LINK, age_ms=None, network_ms=None, clock_ms=None, tracking_ms=None, code="", reason="")
    told.state = partial(scene.state, SessionState.HOLDING, "stale", STALE, hand_link=unknown)
    told.until("the end", lambda: told.page.words("#reason") == STALE)
    told.until("no age", lambda: told.page.words("#link").startswith("age unknown"))


def test_one_machine_that_has_too_much_to_do_is_not_called_a_narrow_link(told: Told) -> None:
    video = VideoLink(carries_mbit_s=0.1, needs_mbit_s=15.0, reason=NARROW)
    told.state = partial(scene.state, SessionState.HOLDING, "stale", STALE, hand_link=LINK, video_link=video)
    busy = "hand samples are 310 ms old (limit 100 ms): this machine has too much to do"
    told.until("the reason", lambda: told.page.words("#reason") == busy)
    trouble = "pictures are sent smaller or fewer: this machine has too much to do (0.1 of 15 Mbit/s)"
    told.until("the pictures' own", lambda: told.page.page.inner_text("[data-name=front_high] .trouble") == trouble)
    told.page.page.keyboard.press("3")
    told.until("on the chosen one", lambda: told.page.words("[data-name=side] .trouble") == trouble)
    told.page.page.keyboard.press("3")


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (VideoTrouble.SLOW_PAGE, "pictures are sent smaller or fewer: this page draws too slowly (5.0 of 15 Mbit/s)"),
        (VideoTrouble.BUSY_HOST, "late pictures: a machine has too much to do"),
    ],
)
def test_who_is_slow_is_said_on_the_picture(apart: Told, code: VideoTrouble, words: str) -> None:
    video = VideoLink(carries_mbit_s=5.0, needs_mbit_s=15.0, reason="it is slow", code=code)
    apart.state = partial(scene.state, SessionState.ENGAGED, "ok", "following", video_link=video)
    apart.until("why", lambda: apart.page.page.inner_text("[data-name=front_high] .trouble") == words)


def test_a_page_that_operates_never_says_that_none_does(told: Told) -> None:
    ready = Readiness(False, "page_silent", NO_PAGE, False)
    told.state = partial(scene.state, SessionState.DISENGAGED, "page_silent", NO_PAGE, readiness=ready)
    told.describe(held=False)
    told.until("what is late", lambda: "operates, but its reports" in told.page.words("#reason"))
    told.until("the events", lambda: "operates, but its reports" in told.page.words("#events"))
    assert "no page operates" not in told.page.page.inner_text("body")
    told.describe()
