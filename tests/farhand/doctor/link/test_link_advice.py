"""What the doctor recommends for a link: the age limit, whether to operate, scale, pictures, protocol."""

from dataclasses import replace
from typing import Any

import pytest

from farhand.doctor.findings import Finding, Severity
from farhand.doctor.link.advice import check_age_limit, check_pictures, check_scale, judge_links, needed_limit_ms
from farhand.doctor.link.figures import LinkFigures, WayFigures
from tests.common.messages.golden_examples import STATE

GOOD = WayFigures(jitter_ms=1.0, excess_p99_ms=4.0, loss=0.0, stalls=0.0, mbit_s=60.0)
TLS, QUIC = "tls/cell:7447", "quic/cell:7447"


def link(endpoint: str = QUIC, round_trip_ms: float = 20.0, **way: Any) -> LinkFigures:
    figures = replace(GOOD, **way)
    return LinkFigures(endpoint, round_trip_ms, round_trip_ms + 2, round_trip_ms + 9, figures, figures)


def named(findings: list[Finding], check: str) -> Finding:
    return next(finding for finding in findings if finding.check == check)


def test_a_quick_link_needs_nothing() -> None:
    found = judge_links([link(TLS), link(QUIC)], [], TLS)
    assert {finding.level for finding in found} == {Severity.OK}
    assert "round trip 20.0 ms at least, 22.0 median, 29.0 p99" in named(found, "link tls").sentence
    assert "about 125 ms, at 80% of full speed" in named(found, "age limit").sentence


@pytest.mark.parametrize(
    ("round_trip_ms", "level", "words"),
    [
        (160.0, "ok", '"auto" will choose about 250 ms, at 40% of full speed'),
        (320.0, "ok", "about 400 ms, at 25%"),
        (340.0, "error", "up to 417 ms old; at most 400 ms can be operated"),
    ],
)
def test_the_age_limit_follows_from_the_link(round_trip_ms: float, level: str, words: str) -> None:
    found = check_age_limit(link(round_trip_ms=round_trip_ms))
    assert (found.level, words in found.sentence) == (level, True), found.sentence


def test_what_the_cell_has_measured_of_tracking_counts() -> None:
    assert STATE.hand_link is not None
    measured = replace(link(), hand=STATE.hand_link)
    assert needed_limit_ms(measured) == pytest.approx(30.25 + 20.0 + 4.0 + 33.5)


def test_lost_samples_make_the_next_one_older() -> None:
    ages = [needed_limit_ms(link(loss=loss)) - needed_limit_ms(link()) for loss in (0.005, 0.03, 0.15, 0.5)]
    assert ages == [0.0, 33.0, 66.0, 198.0]


def test_quic_is_recommended_where_it_makes_samples_younger() -> None:
    lossy = link(TLS, stalls=0.02, excess_p99_ms=120.0)
    found = named(judge_links([lossy, link(QUIC, loss=0.02)], [], TLS), "protocol")
    assert found.level is Severity.WARNING
    assert "by quic hand samples come up to 83 ms younger than by tls" in found.sentence
    assert 'links.control = "quic/..." at the remote site' in found.cure
    assert 'links.remote (of a console links.control) = "quic/cell:7447"' in found.cure
    untried = named(judge_links([lossy], [], TLS), "protocol")
    assert "let UDP through" in untried.cure
    assert named(judge_links([link(TLS, stalls=0.004)], [], TLS), "protocol").level is Severity.OK


def test_tls_is_recommended_where_quic_makes_samples_older() -> None:
    found = named(
        judge_links([link(QUIC, loss=0.4, excess_p99_ms=900.0), link(TLS, stalls=0.03)], [], QUIC), "protocol"
    )
    assert 'links.control = "tls/..."' in found.cure


@pytest.mark.parametrize(
    ("mbit_s", "level", "words"),
    [
        (60.0, "ok", "four views as JPEG"),
        (20.0, "ok", 'video.codec = "auto" sends them as H.264'),
        (3.0, "warning", "four views as H.264 need about 5"),
        (None, "warning", "the arm is engaged"),
    ],
)
def test_the_pictures_follow_from_what_the_way_back_carries(mbit_s: float | None, level: str, words: str) -> None:
    found = check_pictures(link(mbit_s=mbit_s))
    assert (found.level, words in found.sentence) == (level, True)
    assert bool(found.cure) is (level != "ok")


def test_pictures_are_judged_by_tls_whatever_the_hand_goes_by() -> None:
    found = named(judge_links([link(QUIC, mbit_s=0.4), link(TLS, mbit_s=30.0)], [], QUIC), "pictures")
    assert "carries 30.0 Mbit/s" in found.sentence


def test_a_scale_is_suggested_for_the_delay() -> None:
    assert "no smaller scale" in check_scale(link()).sentence
    assert "begin with a scale of 0.65" in check_scale(link(round_trip_ms=240.0)).sentence
    assert "scale of 0.25" in check_scale(link(round_trip_ms=2000.0)).sentence


def test_an_engaged_arm_is_stated() -> None:
    engaged = replace(link(mbit_s=None), engaged=True)
    assert "measured with little, and without load: the arm is engaged" in judge_links([engaged], [], QUIC)[0].sentence
