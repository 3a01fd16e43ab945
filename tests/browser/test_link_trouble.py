"""The page says what is wrong with the links: beside the state, in figures among the facts, and as an event."""

from functools import partial
from pathlib import Path

from msgspec.structs import replace

from bench.page import scene
from common.messages.robot import HandLink, SessionState, VideoLink
from tests.browser.told import Told

CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
STALE = "newest hand sample is 320 ms old (limit 100 ms)"
OLD = "hand samples are too old: 310 ms at arrival and 33 ms apart, where the limit is 100 ms; network 240 ms"
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


def test_a_links_trouble_is_told_with_its_figures(told: Told) -> None:
    video = VideoLink(carries_mbit_s=1.8, needs_mbit_s=31.0, reason=NARROW)
    told.state = partial(scene.state, SessionState.HOLDING, "stale", STALE, hand_link=LINK, video_link=video)
    told.until("the reason", lambda: told.page.words("#reason") == f"{STALE} · {OLD} · {NARROW}")
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
