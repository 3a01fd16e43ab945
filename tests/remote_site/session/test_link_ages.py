"""Ages of samples on a link: what of the last half minute is kept, and how far apart the cameras' pictures are."""

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.session.link_ages import WINDOW_S, ArrivedSample, LinkAges

OUTAGE_NS = 500 * NS_PER_MS
PERIOD_MS = 33


def note(ages: LinkAges, seq: int, capture_ms: float, age_ms: float) -> None:
    capture_ns = round(capture_ms * NS_PER_MS)
    ages.note(ArrivedSample(seq, capture_ns, capture_ns, capture_ns + round(age_ms * NS_PER_MS)))


def test_ages_are_forgotten_half_a_minute_after_their_own_second_and_not_after_the_first() -> None:
    ages = LinkAges(OUTAGE_NS)
    for seq in range(90):
        note(ages, seq, PERIOD_MS * seq, 200.0 if seq in (70, 75) else 20.0)
    late_s = (WINDOW_S + PERIOD_MS * 75 // 1000) * NS_PER_S
    assert ages.needed_ns(late_s) == (200 + PERIOD_MS) * NS_PER_MS
    assert ages.needed_ns(late_s + 2 * NS_PER_S) == 0


def test_the_cameras_spacing_is_what_two_of_ten_reach() -> None:
    ages, capture_ms = LinkAges(OUTAGE_NS), 0.0
    for seq, spacing_ms in enumerate([30.0] * 9 + [60.0, 50.0]):
        capture_ms += spacing_ms
        note(ages, seq, capture_ms, 20.0)
    assert ages.spacing_ns() == 50 * NS_PER_MS
