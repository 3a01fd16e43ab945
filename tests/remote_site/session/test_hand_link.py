"""The hand's link as measured where samples arrive: parts of the age, jitter, loss; and what is said to be wrong."""

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS, ClockOffset
from common.messages.hand import HandArm, TrackingStatus
from common.messages.robot import HandLink
from remote_site.session.hand_link_meter import MOST_ARRIVALS, HandLinkMeter, SampleAge
from remote_site.session.hand_link_verdict import judged
from tests.present import present
from tests.remote_site.remote_loop import hand

PERIOD_MS = 33
START_MS = 10_000
APART_MS = 5_000  # the local clock is ahead


def sample(seq: int, tracking_ms: float = 30.0, session: int = 7) -> HandArm:
    captured_ms = START_MS + APART_MS + seq * PERIOD_MS
    sent_ns = round((captured_ms + tracking_ms) * NS_PER_MS)
    return msgspec.structs.replace(hand(seq, captured_ms * NS_PER_MS, session=session), sent_ns=sent_ns)


def arrive(
    meter: HandLinkMeter, seq: int, network_ms: float, unsure_ms: float = 40.0, tracking_ms: float = 30.0
) -> int:
    """Let a sample come, and return when."""
    now_ns = round((START_MS + seq * PERIOD_MS + tracking_ms + network_ms) * NS_PER_MS)
    offset = ClockOffset(APART_MS * NS_PER_MS, round(unsure_ms * NS_PER_MS))
    meter.arrive(sample(seq, tracking_ms), offset, now_ns)
    return now_ns


def measured(meter: HandLinkMeter, now_ns: int) -> HandLink:
    figures = meter.figures(now_ns)
    assert figures is not None
    return figures


def test_the_age_at_arrival_is_the_sum_of_tracking_network_and_clocks() -> None:
    meter = HandLinkMeter()
    for seq in range(40):
        now_ns = arrive(meter, seq, network_ms=240.0)
    link = measured(meter, now_ns)
    assert (link.network_ms, link.clock_ms, link.tracking_ms) == (240.0, 40.0, 30.0)
    assert link.age_ms == 310.0
    assert link.interval_ms == PERIOD_MS
    assert link.jitter_ms == 0.0
    assert link.loss == 0.0


def test_what_comes_after_a_newer_sample_tells_nothing_about_the_time_that_the_link_takes() -> None:
    meter = HandLinkMeter()
    for seq in range(40):
        now_ns = arrive(meter, seq, network_ms=20.0)
    for seq in [*range(40), *[39] * 40]:
        now_ns += NS_PER_MS
        meter.arrive(sample(seq), ClockOffset(APART_MS * NS_PER_MS, 0), now_ns)
    link = measured(meter, now_ns)
    assert (link.network_ms, link.interval_ms, link.jitter_ms, link.loss) == (20.0, PERIOD_MS, 0.0, 0.0)


def test_the_figures_are_measured_five_times_a_second() -> None:
    meter = HandLinkMeter()
    for seq in range(40):
        now_ns = arrive(meter, seq, network_ms=20.0)
    first = measured(meter, now_ns)
    for seq in range(40, 120):
        arrive(meter, seq, network_ms=90.0)
    assert meter.figures(now_ns + 200 * NS_PER_MS - 1) is first
    assert measured(meter, now_ns + 200 * NS_PER_MS).network_ms == 90.0


def test_how_long_tracking_takes_while_it_learns_the_arm_is_no_age() -> None:
    meter, offset = HandLinkMeter(), ClockOffset(APART_MS * NS_PER_MS, 40 * NS_PER_MS)
    for seq in range(10):
        now_ns = round((START_MS + seq * PERIOD_MS + 165.0 + 20.0) * NS_PER_MS)
        learning = msgspec.structs.replace(sample(seq, tracking_ms=165.0), status=TrackingStatus.INITIALISING)
        meter.arrive(learning, offset, now_ns)
    figures = measured(meter, now_ns)
    assert (figures.age_ms, figures.tracking_ms, figures.network_ms) == (60.0, 0.0, 20.0)
    assert present(judged(figures, 100.0)).code == ""
    late = HandLinkMeter()
    for seq in range(10):
        now_ns = arrive(late, seq, network_ms=20.0, tracking_ms=165.0)
    assert present(judged(measured(late, now_ns), 100.0)).code == "samples_old"


def test_half_a_round_trip_is_what_most_samples_show() -> None:
    meter = HandLinkMeter()
    assert meter.network_ms is None
    for seq in range(100):
        now_ns = arrive(meter, seq, network_ms=900.0 if seq % 5 == 0 else 20.0)
    measured(meter, now_ns)
    assert meter.network_ms == 20.0


def test_the_age_that_one_sample_in_twenty_exceeds_is_reported() -> None:
    meter = HandLinkMeter()
    for seq in range(100):
        now_ns = arrive(meter, seq, network_ms=200.0 if seq % 10 == 0 else 20.0)
    assert measured(meter, now_ns).network_ms == 200.0
    rare = HandLinkMeter()
    for seq in range(100):
        now_ns = arrive(rare, seq, network_ms=200.0 if seq % 50 == 0 else 20.0)
    assert measured(rare, now_ns).network_ms == 20.0


def test_loss_is_what_never_came_and_neither_reordering_nor_doubling() -> None:
    meter, order = HandLinkMeter(), [*range(40)]
    order[10], order[11] = order[11], order[10]
    for seq in [*order, 39]:
        now_ns = arrive(meter, seq, network_ms=20.0)
    assert measured(meter, now_ns).loss == 0.0
    overtaken = HandLinkMeter()
    for seq in [5, 3, *range(6, 40)]:
        now_ns = arrive(overtaken, seq, network_ms=20.0)
    assert measured(overtaken, now_ns).loss == 0.0
    lossy = HandLinkMeter()
    for seq in (seq for seq in range(100) if seq % 10 != 5):
        now_ns = arrive(lossy, seq, network_ms=20.0)
    assert measured(lossy, now_ns).loss == pytest.approx(0.1, abs=0.01)


def test_from_three_in_a_hundred_on_lost_samples_are_said() -> None:
    meter = HandLinkMeter()
    for seq in range(50):
        now_ns = arrive(meter, seq, network_ms=20.0)
    link = measured(meter, now_ns)
    codes = [present(judged(msgspec.structs.replace(link, loss=loss), 400.0)).code for loss in (0.0299, 0.03)]
    assert codes == ["", "samples_lost"]


def test_jitter_is_the_mean_change_of_the_time_in_the_network_whatever_the_offset() -> None:
    meter, rng = HandLinkMeter(), np.random.default_rng(3)
    for seq in range(150):
        now_ns = arrive(meter, seq, network_ms=50.0 + rng.uniform(0, 30), unsure_ms=rng.uniform(10, 90))
    assert measured(meter, now_ns).jitter_ms == pytest.approx(10.0, rel=0.2)  # a third of a uniform spread


def test_only_the_last_five_seconds_and_the_newest_session_count() -> None:
    meter = HandLinkMeter()
    for seq in range(30):
        arrive(meter, seq, network_ms=300.0)
    for seq in range(190, 340):
        now_ns = arrive(meter, seq, network_ms=20.0)
    assert measured(meter, now_ns).network_ms == 20.0
    meter.arrive(sample(0, session=8), ClockOffset(0, 0), now_ns)
    assert meter.figures(now_ns) is None


def test_nothing_is_said_of_a_link_that_is_good_enough() -> None:
    meter = HandLinkMeter()
    for seq in range(40):
        now_ns = arrive(meter, seq, network_ms=15.0, unsure_ms=15.0)
    link = measured(meter, now_ns)
    assert judged(link, 100.0) == link
    assert present(judged(link, 60.0)).code == "samples_old"


@pytest.mark.parametrize(
    ("network_ms", "unsure_ms", "tracking_ms", "cure"),
    [
        (240.0, 40.0, 30.0, "quicker way"),
        (30.0, 60.0, 30.0, "half of the quickest round trip"),
        (5.0, 3.0, 95.0, "host"),
    ],
)
def test_within_five_seconds_it_says_which_part_makes_samples_too_old(
    network_ms: float, unsure_ms: float, tracking_ms: float, cure: str
) -> None:
    meter = HandLinkMeter()
    for seq in range(200):
        good_ns = arrive(meter, seq, network_ms=5.0, unsure_ms=3.0)
    assert present(judged(measured(meter, good_ns), 100.0)).code == ""
    for seq in range(200, 340):
        now_ns = arrive(meter, seq, network_ms, unsure_ms, tracking_ms)
        link = present(judged(measured(meter, now_ns), 100.0))
        if link.code:
            break
    assert link.code == "samples_old"
    assert now_ns - good_ns < 2_000 * NS_PER_MS
    assert f"network {network_ms:.0f} ms, clocks {unsure_ms:.0f} ms, tracking {tracking_ms:.0f} ms" in link.reason
    assert cure in link.reason.partition("ms. ")[2]


@pytest.mark.parametrize(
    ("network_ms", "unsure_ms", "swing_ms"), [(240.0, 5.0, 0.0), (240.0, 5.0, 120.0), (30.0, 80.0, 0.0)]
)
@pytest.mark.parametrize("one_host", [True, False])
def test_old_samples_may_come_from_the_load_of_a_host(
    network_ms: float, unsure_ms: float, swing_ms: float, *, one_host: bool
) -> None:
    meter = HandLinkMeter()
    for seq in range(60):
        now_ns = arrive(meter, seq, network_ms + swing_ms * (seq % 2), unsure_ms)
    link = present(judged(measured(meter, now_ns), 100.0, one_host=one_host))
    assert link.code == "samples_old"
    assert ("this machine if it is overloaded" if one_host else "a host that is overloaded") in link.reason
    assert ("Wi-Fi" in link.reason, "quic/" in link.reason) == (not one_host, not one_host and swing_ms > 0)
    assert len(link.reason) <= 400


def test_a_link_that_loses_samples_says_so_within_five_seconds() -> None:
    meter, rng = HandLinkMeter(), np.random.default_rng(1)
    for seq in range(150):
        now_ns = arrive(meter, seq, network_ms=5.0, unsure_ms=3.0)
    begin_ns, link = now_ns, judged(measured(meter, now_ns), 100.0)
    seq = 150
    while present(link).code == "" and now_ns - begin_ns < 5_000 * NS_PER_MS:
        seq += 1
        if rng.random() > 0.1:
            now_ns = arrive(meter, seq, network_ms=5.0, unsure_ms=3.0)
            link = judged(measured(meter, now_ns), 100.0)
    assert present(link).code == "samples_lost"
    assert "% of the hand samples are lost" in present(link).reason


def test_samples_without_the_clocks_offset_say_so_at_once() -> None:
    meter = HandLinkMeter()
    for seq in range(40):
        now_ns = arrive(meter, seq, network_ms=5.0, unsure_ms=3.0)
    now_ns += 200 * NS_PER_MS
    meter.arrive(sample(46), None, now_ns)
    link = present(judged(measured(meter, now_ns), 100.0))
    assert link.age_ms is None
    assert link.code == "clock_unknown"


def test_a_sender_that_does_not_tell_when_it_sent_has_all_in_the_network() -> None:
    age = SampleAge.of(hand(1, 100 * NS_PER_MS), ClockOffset(0, 5 * NS_PER_MS), 150 * NS_PER_MS)
    assert age == SampleAge(0, 50 * NS_PER_MS, 5 * NS_PER_MS)
    assert age.total_ns == 55 * NS_PER_MS


@pytest.mark.parametrize(("period_ms", "tracking_ms", "cure"), [(68, 55.0, "more pictures"), (33, 95.0, "relieve")])
def test_rare_samples_are_told_by_the_rate_of_the_cameras(period_ms: int, tracking_ms: float, cure: str) -> None:
    meter = HandLinkMeter()
    for seq in range(60):
        captured_ns = (START_MS + seq * period_ms) * NS_PER_MS
        sent_ns = captured_ns + round(tracking_ms * NS_PER_MS)
        now_ns = sent_ns + 5 * NS_PER_MS
        meter.arrive(
            msgspec.structs.replace(hand(seq, captured_ns), sent_ns=sent_ns), ClockOffset(0, 3_000_000), now_ns
        )
    link = present(judged(measured(meter, now_ns), 125.0))
    told = f"a sample each {period_ms} ms, {tracking_ms + 8:.0f} ms old at arrival; the limit is 125 ms"
    assert told in link.reason
    assert cure in link.reason


def test_a_flood_of_samples_is_measured_by_the_newest_alone() -> None:
    meter = HandLinkMeter()
    offset, now_ns = ClockOffset(APART_MS * NS_PER_MS, 0), START_MS * NS_PER_MS
    for count, late_ms in ((20_000, 90.0), (MOST_ARRIVALS, 20.0)):
        for _ in range(count):  # 20 000 a second
            now_ns += NS_PER_MS // 20
            captured_ns = now_ns + round((APART_MS - late_ms) * NS_PER_MS)
            meter.arrive(hand(1, captured_ns), offset, now_ns)
    assert measured(meter, now_ns).age_ms == pytest.approx(20.0)
