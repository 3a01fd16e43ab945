"""What the measurements of the page rest on: a clock that is read from what the browser has painted."""

import numpy as np

from common.clock import NS_PER_MS
from lab.measure.page.chromium import Tab
from lab.measure.page.painted_clock import PageClock, ages_ms
from lab.stage.clock_strip import draw_clock

EXPOSED_MS = 4_000_000


class Page(Tab):
    """Has painted two pictures, of which one cannot be read."""

    def __init__(self) -> None:
        """No browser."""

    def evaluate(self, _script: str) -> list[list[object]]:
        image = np.zeros((240, 44 * 4, 3), np.uint8)
        draw_clock(image, EXPOSED_MS * NS_PER_MS)
        cells = "".join("1" if level > 128 else "0" for level in image[2, 2::4, 1])
        return [["side", 130.5, cells], ["side", 140.5, cells.replace("1", "?", 1)]]


def test_the_age_of_a_painted_picture_is_read_from_the_clock_in_it():
    assert ages_ms(Page(), PageClock(EXPOSED_MS - 100.0, 0.5)) == {"side": [30.5]}
