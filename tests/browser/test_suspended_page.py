"""After a suspend of the page's host the picture that is still shown is told to be as old as it is."""

import pytest

from tests.browser.told import Told

SUSPEND = "() => { window.realNow = Date.now; Date.now = () => window.realNow.call(Date) + 600_000; }"
RESUME = "() => { Date.now = window.realNow; }"
AGE = "() => document.querySelector('[data-name=side]').textContent"


@pytest.mark.slow
def test_a_picture_from_before_a_suspend_of_ten_minutes_is_ten_minutes_old(told: Told) -> None:
    """In a suspend the wall clock goes on, and the clocks of page and console stand still."""
    page = told.page.page
    told.until("a live picture", lambda: told.mark("side") == "live")
    page.evaluate(SUSPEND)
    try:
        page.wait_for_function("() => document.querySelector('[data-name=side]').dataset.mark === 'old'")
        page.wait_for_timeout(500)
        assert "600." in page.evaluate(AGE)
        told.until("a new picture, which is young", lambda: told.mark("side") == "live")
        assert "600." not in page.evaluate(AGE)
    finally:
        page.evaluate(RESUME)
