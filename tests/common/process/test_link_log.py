"""The log of a link's trouble: one line when it begins, changes or ends, not one for each state."""

from structlog.testing import capture_logs

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import HandLink, VideoLink, VideoTrouble
from common.process.link_log import LinkLog

GOOD = HandLink(
    age_ms=310.2, network_ms=240.0, clock_ms=40.0, tracking_ms=30.2, interval_ms=33.4, jitter_ms=2.0, loss=0.0123
)
OLD = HandLink(
    **{name: getattr(GOOD, name) for name in GOOD.__struct_fields__} | {"code": "samples_old", "reason": "r"}
)
NARROW = VideoLink(carries_mbit_s=1.8, needs_mbit_s=31.0, reason="the link carries 1.8 Mbit/s")


def test_trouble_is_logged_once_with_its_figures_and_so_is_its_end() -> None:
    log = LinkLog()
    with capture_logs() as lines:
        for k in range(500):
            log.note(OLD if k < 250 else GOOD, None, k * 20 * NS_PER_MS)
    assert [(line["log_level"], line["code"]) for line in lines] == [("warning", "samples_old"), ("info", "ok")]
    figures = {"age_ms": 310, "network_ms": 240, "clock_ms": 40, "tracking_ms": 30, "interval_ms": 33, "loss": 0.012}
    assert figures.items() <= lines[0].items()


def test_trouble_that_comes_and_goes_is_logged_every_three_seconds_at_most() -> None:
    log = LinkLog()
    with capture_logs() as lines:
        for k in range(600):
            log.note(OLD if k % 2 else GOOD, None, k * 20 * NS_PER_MS)
    assert 3 <= len(lines) <= 5


def test_what_lasts_is_repeated_each_minute_and_links_are_told_apart() -> None:
    log = LinkLog()
    with capture_logs() as lines:
        for k in range(61):
            log.note(OLD, NARROW, k * NS_PER_S)
    assert [line["event"] for line in lines] == ["link of the hand", "link of the pictures"] * 2
    assert (lines[1]["carries_mbit_s"], lines[1]["needs_mbit_s"]) == (1.8, 31.0)


def test_a_full_processor_is_logged_under_its_own_code() -> None:
    log, busy = LinkLog(), VideoLink(carries_mbit_s=31.0, needs_mbit_s=31.0, reason="r", code=VideoTrouble.BUSY_HOST)
    with capture_logs() as lines:
        log.note(None, NARROW, 0)
        log.note(None, busy, 10 * NS_PER_S)
    assert [line["code"] for line in lines] == ["narrow", "busy_host"]


def test_nothing_is_logged_of_good_links() -> None:
    log = LinkLog()
    with capture_logs() as lines:
        log.note(None, None, 0)
        log.note(GOOD, None, NS_PER_S)
    assert lines == []


def test_a_changed_age_limit_and_a_link_that_is_too_slow_are_logged_once() -> None:
    log, slow = LinkLog(), ("link_too_slow", "the link takes 310 ms; at most 250 can be operated")
    with capture_logs() as lines:
        for limit_ms, why in ((100.0, ("ok", "")), (200.0, ("ok", "")), (200.0, slow), (200.0, slow)):
            log.note_limit(limit_ms, 100.0 / limit_ms, *why)
    assert [line["event"] for line in lines] == ["age limit", "the link is too slow"]
    assert (lines[0]["ms"], lines[0]["speed"]) == (200.0, "50%")
    assert lines[1]["reason"] == "the link takes 310 ms; at most 250 can be operated"
