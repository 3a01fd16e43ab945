"""What a run says: every change that lasts, and no flood."""

from collections.abc import Callable

from common.clock import NS_PER_S
from local_site.programmed.path_runs import Announcements

STEP_NS = NS_PER_S // 60


def said(words_at: Callable[[float], str]) -> list[str]:
    """What is told over five seconds of words by their time in s."""
    told = list[str]()
    announcements = Announcements(told.append)
    for now_ns in range(0, 5 * NS_PER_S, STEP_NS):
        announcements.offer(words_at(now_ns / NS_PER_S), now_ns)
    return told


def test_a_change_is_told_once_and_at_once():
    assert said(lambda at_s: "waits" if at_s < 2.0 else "runs") == ["waits", "runs"]


def test_figures_that_change_all_the_time_are_told_twice_a_second():
    told = said(lambda at_s: f"{60 + 100 * at_s:.0f} mm behind")
    assert 9 <= len(told) <= 11


def test_what_came_too_soon_after_the_last_words_is_told_as_soon_as_it_may():
    assert said(lambda at_s: "waits" if at_s < 1.0 else "approaches" if at_s < 1.1 else "runs") == [
        "waits",
        "approaches",
        "runs",
    ]
