"""The clutch as each receiver of its reports knows it: only a release in an unbroken row of reports ends it."""

from hypothesis import given
from hypothesis import strategies as st

from common.messages.clutch_latch import ClutchLatch
from common.messages.hand import ClutchKey

UP, DOWN, UNSEEN = ClutchKey
REPORTS = st.lists(st.sampled_from([UP, DOWN, UNSEEN, None]), max_size=30)


def latch(*reports: ClutchKey | None) -> ClutchLatch:
    """One that has seen these; None is an interruption."""
    made = ClutchLatch()
    for report in reports:
        if report is None:
            made.interrupt()
        else:
            made.see(report)
    return made


def test_it_begins_up_and_is_what_is_reported() -> None:
    assert latch().key is UP
    assert latch(None, UP).key is UP
    assert latch(DOWN).key is DOWN
    assert latch(DOWN, UP).key is UP


def test_after_an_interruption_it_is_up_again_only_by_a_press_and_its_release() -> None:
    assert latch(DOWN, None).key is UNSEEN
    assert latch(DOWN, None, UP, UP, None, UP).key is UNSEEN
    assert latch(DOWN, UNSEEN, UP).key is UNSEEN
    assert latch(UNSEEN, UP).key is UNSEEN
    assert latch(DOWN, None, UP, DOWN).key is DOWN
    assert latch(DOWN, None, UP, DOWN, UP).key is UP


@given(REPORTS)
def test_however_reports_go_on_through_several_receivers_the_last_is_up_only_if_the_first_is(
    reports: list[ClutchKey | None],
) -> None:
    first, last = ClutchLatch(), ClutchLatch()
    for report in reports:
        if report is None:
            first.interrupt()
        else:
            first.see(report)
        last.see(first.key)
        assert last.key is first.key


@given(REPORTS)
def test_it_is_up_after_a_press_only_where_the_report_before_the_first_up_was_down(
    reports: list[ClutchKey | None],
) -> None:
    made = ClutchLatch()
    before: ClutchKey | None = UP
    for report in reports:
        was = made.key
        if report is None:
            made.interrupt()
        else:
            made.see(report)
        if was is not UP and made.key is UP:
            assert (before, report) == (DOWN, UP)
        before = report
