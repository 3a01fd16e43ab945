"""Where the remote site says that no page operates, a console whose page does says what is late."""

import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.requests import Reply
from common.messages.robot import NO_PAGE, HandLink, Readiness, SessionState
from lab.measure.page import scene
from local_site.console.model.late_reports import answered, late_reports, named
from local_site.console.model.seat import Seat, Visitor
from remote_site.reasons import Code

NOW_NS = 100 * NS_PER_S
OLD = HandLink(
    age_ms=310.0,
    network_ms=240.0,
    clock_ms=40.0,
    tracking_ms=30.0,
    interval_ms=33.0,
    jitter_ms=4.4,
    loss=0.0,
    code="samples_old",
    reason="too old",
)


def seat(beat_ms: int, heard_ms: int) -> Seat:
    """A page that operates, whose last beat came so long ago, and had then heard the console's word of so long ago."""
    taken = Seat(open_=True)
    page = Visitor(1, "127.0.0.1")
    taken.arrive(page, NOW_NS - NS_PER_S)
    taken.beat(page, NOW_NS - beat_ms * NS_PER_MS, NOW_NS - heard_ms * NS_PER_MS, down=False)
    return taken


@pytest.mark.parametrize(
    ("beat_ms", "heard_ms", "hand_ms", "link", "said"),
    [
        (350, 360, 10, None, "its last report came 350 ms ago (limit 200 ms)"),
        (20, 620, 10, None, "its reports come 620 ms late (limit 400 ms)"),
        (20, 40, None, None, "the local site, which passes its reports on, is silent"),
        (20, 40, 10, OLD, "reach the robot 310 ms late (limit 100 ms)"),
        (20, 40, 10, None, "its reports reach the local site too late"),
    ],
)
def test_what_is_late_is_named(
    beat_ms: int, heard_ms: int, hand_ms: int | None, link: HandLink | None, said: str
) -> None:
    state = scene.state(SessionState.HOLDING, "page_silent", NO_PAGE, hand_link=link)
    hand_ns = None if hand_ms is None else NOW_NS - hand_ms * NS_PER_MS
    words = late_reports(seat(beat_ms, heard_ms), hand_ns, state, NOW_NS)
    assert words.startswith("page 1 operates, but ")
    assert said in words


def test_without_a_page_nothing_is_said_in_its_place() -> None:
    ready = Readiness(False, "page_silent", NO_PAGE, False)
    state = scene.state(SessionState.DISENGAGED, "latched", f"disengaged, {NO_PAGE}; engage again", readiness=ready)
    assert late_reports(Seat(open_=True), NOW_NS, state, NOW_NS) == ""
    assert named(state, "") is state


def test_the_words_stand_wherever_the_sentence_stood() -> None:
    assert Code.PAGE_SILENT.sentence == NO_PAGE
    ready = Readiness(False, "page_silent", NO_PAGE, False)
    state = scene.state(SessionState.DISENGAGED, "latched", f"disengaged, {NO_PAGE}; engage again", readiness=ready)
    told = named(state, "page 1 is late")
    assert (told.reason, told.readiness.reason) == ("disengaged, page 1 is late; engage again", "page 1 is late")
    refused = Reply(id=1, done=False, code="page_silent", reason=NO_PAGE)
    assert answered(refused, "page 1 is late").reason == "page 1 is late"
    assert answered(refused, "") == refused
