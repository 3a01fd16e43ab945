"""No picture goes behind one that waits in this host too long: a pause of TCP costs pictures, and makes none late."""

import pytest

from lab.measure.video.link import Arrival, StreamRun
from remote_site.video.streaming.departures import Departures
from remote_site.video.streaming.link_rate import LATE_MS, USED, LinkRate
from remote_site.video.streaming.sent_pictures import Arrivals
from tests.remote_site.video.streaming.test_h264_adaptation import CONFIG, HELD_BYTES, Scene, pictures, settings
from tests.remote_site.video.streaming.test_long_links import MS, REPORT_NS, fps, waited_ms

SIZE = 4000
LATE_NS = round(LATE_MS * MS)


def seeing(mbit_s: float, delay_ms: float) -> StreamRun:
    """Pictures over a link whose queue the sender sees."""
    run = StreamRun(CONFIG, pictures(Scene()), mbit_s, h264=True, sees_queue=True)
    run.link.holds_bytes, run.link.delay_ms = HELD_BYTES, delay_ms
    return run


def paused(run: StreamRun) -> list[Arrival]:
    """Twenty seconds with two pauses as BBR makes them: next to nothing is sent for 200 ms and a round trip."""
    mbit_s, pause_s, arrivals = run.link.mbit_s, 0.2 + 2 * run.link.delay_ms / 1000, []
    for _ in range(2):
        arrivals += run.run(5.0)
        run.link.mbit_s = 0.0
        arrivals += run.run(pause_s)
        run.link.mbit_s = mbit_s
        arrivals += run.run(5.0 - pause_s)
    return arrivals


def test_a_camera_waits_while_a_late_picture_of_it_is_not_sent_and_no_longer() -> None:
    departures = Departures()
    departures.put("side", SIZE, 0)
    departures.put("front", SIZE, 50 * MS)
    assert not departures.waits("side", 2 * SIZE, LATE_NS - 1)
    assert departures.waits("side", 2 * SIZE, LATE_NS)
    assert not departures.waits("front", 2 * SIZE, LATE_NS)
    assert not departures.waits("side", SIZE, LATE_NS)  # what waits now is the other's, put after it
    assert not departures.waits("side", 0, 10 * LATE_NS)


def test_of_a_camera_that_sends_often_the_oldest_picture_that_waits_counts() -> None:
    departures = Departures()
    for k in range(3):
        departures.put("side", SIZE, k * 33 * MS)
    assert departures.waits("side", 3 * SIZE, 99 * MS)
    assert not departures.waits("side", 2 * SIZE, 99 * MS)
    assert departures.waits("side", 2 * SIZE, 33 * MS + LATE_NS)


def test_who_has_sent_nothing_does_not_wait() -> None:
    assert not Departures().waits("side", 0, LATE_NS)


@pytest.mark.parametrize("delay_ms", [80.0, 120.0])
def test_a_pause_makes_next_to_no_picture_late(delay_ms: float) -> None:
    run = seeing(5.0, delay_ms)
    run.run(6.0)
    arrivals = paused(run)
    assert waited_ms(run, arrivals, 98) < 50.0
    assert fps(arrivals, 20.0) > 28.0
    assert {setting.scale for setting in settings(run)} == {1.0}
    in_the_end = run.run(2.0)
    assert waited_ms(run, in_the_end, 100) < 50.0
    assert fps(in_the_end, 2.0) > 29.0


@pytest.mark.slow
@pytest.mark.parametrize("delay_ms", [0.0, 40.0, 120.0])
@pytest.mark.parametrize("mbit_s", [2.0, 5.0])
def test_what_is_held_back_shows_what_the_link_carries(mbit_s: float, delay_ms: float) -> None:
    run = seeing(mbit_s, delay_ms)
    run.run(8.0)
    arrivals = run.run(15.0)
    assert fps(arrivals, 15.0) > 28.0
    assert waited_ms(run, arrivals, 95) < 100.0
    assert sum(arrival.size for arrival in arrivals) * 8 / 15.0 > 0.3e6 * mbit_s


def reported(held: list[bool], carried: float) -> LinkRate:
    """After one report each tenth of a second, without a late picture; `carried` is the fraction that comes."""
    rate = LinkRate()
    for k, is_held in enumerate(held):
        arrivals = Arrivals(10_000, round(10_000 * carried), 9_000, 120.0, 240.0, 0.0, held_back=is_held)
        rate.report(arrivals, 1e6, k * REPORT_NS, cautious=True)
    return rate


def test_a_link_is_full_where_pictures_are_held_back_again_and_again_though_none_is_late() -> None:
    sometimes = [k % 4 == 0 for k in range(40)]
    assert reported(sometimes, 0.6).carries == pytest.approx(60_000, rel=0.1)
    assert reported(sometimes, 1.0).carries is not None
    assert reported([False] * 40, 0.6).carries is None


@pytest.mark.parametrize("reports", [2, 5, 7])
def test_pictures_held_back_for_a_pause_are_no_full_link(reports: int) -> None:
    held = [10 <= k < 10 + reports for k in range(40)]
    assert reported(held, 0.5).carries is None


def test_a_link_that_carries_nothing_for_a_second_is_not_found_narrower_and_narrower() -> None:
    rate, found = LinkRate(), []
    for k in range(45):
        stands = 30 <= k < 42
        carried, overdue_ms = (0, 340.0 + 100.0 * (k - 30)) if stands else (20_000, 0.0)
        arrivals = Arrivals(25_000, carried, 9_000, 120.0, 240.0, overdue_ms, held_back=stands)
        rate.report(arrivals, 1e6, k * REPORT_NS, cautious=True)
        found.append(rate.budget(1e6))
    assert min(budget for budget in found[30:] if budget is not None) > 0.2 * USED * 200_000
