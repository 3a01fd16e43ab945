"""What the sites have logged is shown as rows of words, not as it stands in a log."""

from common.process.log import LOGFMT
from farhand.loopback.display import rows_of


def logged(site: str, **fields: object) -> str:
    """A site's line, as a loopback keeps it."""
    return f"{site}: {LOGFMT(None, '', {'level': 'warning', 'time': '2026-01-01T00:00:00Z', 'site': site, **fields})}"


def test_a_line_of_a_log_becomes_a_row_of_words() -> None:
    line = logged("remote", event="link of the hand", code="samples_old", reason='too "old": 165 ms', age_ms=165)
    assert rows_of([line]) == [("remote", "warning", 'link of the hand: too "old": 165 ms')]


def test_without_a_reason_its_figures_stand_there() -> None:
    assert rows_of([logged("local", event="slow camera", camera="left", fps=9.8)]) == [
        ("local", "warning", "slow camera: camera left, fps 9.8")
    ]
    assert rows_of([logged("local", event="no real-time scheduling")]) == [
        ("local", "warning", "no real-time scheduling")
    ]


def test_what_two_sites_say_in_the_same_words_is_shown_once() -> None:
    lines = [logged(site, event="link", reason="narrow", rate=rate) for site, rate in (("local", 1), ("remote", 2))]
    assert rows_of([*lines, lines[0]]) == [("local, remote", "warning", "link: narrow")]


def test_what_is_no_log_line_is_shown_as_it_is() -> None:
    assert rows_of(["3.2 s: holding, hand samples are late"]) == [("arm", "", "3.2 s: holding, hand samples are late")]
    assert rows_of(["local: farhand: cannot open 0"]) == [("local", "", "farhand: cannot open 0")]
