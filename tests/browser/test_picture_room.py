"""The pictures fill their room, however many a cell has: no black, nothing cut off; a chosen one is large."""

from collections.abc import Iterator
from itertools import combinations

import pytest

from lab.measure.page import scene
from tests.browser.many_views import FULL, WIDE, Box, boxes, painted, show_views
from tests.browser.told import Told, opened_told

SIZES = ((390, 844), (1280, 720), (1920, 1080), (2560, 1440))
FILLED = 0.96  # the rest is the gaps between them, 2 px wide
LEAST_SHARE = 0.43  # of the window
KINDS = {"alike": (FULL,), "wide": (WIDE,), "mixed": (WIDE, FULL, FULL)}


@pytest.fixture(scope="module")
def told_here(browser: object) -> Iterator[Told]:
    """A page of its own: its cell has other cameras."""
    with opened_told(browser) as told:
        yield told


@pytest.fixture
def views(told_here: Told) -> Iterator[Told]:
    told_here.reset()
    yield told_here
    told_here.page.page.evaluate("() => localStorage.removeItem('farhand-large')")
    told_here.page.resize(1280, 720)


def meet(one: Box, other: Box) -> bool:
    """Whether two boxes overlap by more than a pixel."""
    return all(min(one[k] + one[k + 2], other[k] + other[k + 2]) - max(one[k], other[k]) > 1 for k in (0, 1))


@pytest.mark.slow
@pytest.mark.parametrize("count", range(1, 9))
def test_any_number_of_views_fills_the_room_at_every_size(views: Told, count: int) -> None:
    show_views(views, [FULL] * count)
    for width, height in SIZES:
        views.page.resize(width, height)
        room = painted(views)
        assert room.filled >= FILLED, (count, width)
        assert not any(meet(*pair) for pair in combinations(room.views, 2)), (count, width)
        if width >= 1280:
            assert sum(w * h for _, _, w, h in room.views) >= LEAST_SHARE * width * height, (count, width)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wide", "mixed"])
@pytest.mark.parametrize("count", [1, 2, 3, 6])
def test_pictures_of_other_shapes_fill_it_too_uncut_and_without_bars(views: Told, kind: str, count: int) -> None:
    shapes = [KINDS[kind][k % len(KINDS[kind])] for k in range(count)]
    show_views(views, shapes)
    for size in SIZES[:3]:
        views.page.resize(size[0], size[1])
        room = painted(views)
        assert room.filled >= FILLED, size
        for (high, wide), (_, _, width, height) in zip(shapes, room.views, strict=True):
            assert (width + 2) / (height + 2) == pytest.approx(wide / high, rel=0.02), size


@pytest.mark.slow
@pytest.mark.parametrize("count", [2, 3, 4, 8])
def test_the_chosen_view_is_the_largest_with_the_others_beside_it_and_stays_so(views: Told, count: int) -> None:
    page = views.page.page
    show_views(views, [FULL] * count)
    alike = [box[2] for box in painted(views).views]
    page.keyboard.press("2")
    room = painted(views)
    assert room.filled >= FILLED
    assert not any(meet(*pair) for pair in combinations(room.views, 2))
    assert room.views[1][2] >= 1.3 * max(box[2] for k, box in enumerate(room.views) if k != 1)
    page.reload()
    show_views(views, [FULL] * count)
    assert [box[2] for box in painted(views).views] == [box[2] for box in room.views]
    page.click("[data-name=view_1]")
    assert [box[2] for box in painted(views).views] == alike


def test_a_camera_that_the_cell_has_no_more_leaves_no_hole(views: Told) -> None:
    show_views(views, [FULL] * 4)
    show_views(views, [FULL] * 3)
    assert painted(views).filled >= FILLED


def test_a_cell_without_a_camera_says_so_and_shows_the_arm_and_the_operator_instead(views: Told) -> None:
    views.previews = ("left", "right")
    show_views(views, [])
    views.until("the words", lambda: "This cell has no camera" in views.page.words("#no-views"))
    views.until("the arm", lambda: views.page.state() == "engaged")
    assert "No live picture" not in views.page.words("#step-words")
    width, height = boxes(views, "#arm")[0][2:]
    assert width * height > 0.15 * 1280 * 720
    assert min(box[2] for box in boxes(views, "#previews .view")) > 250
    views.shot("no camera")
    views.describe()
    views.cameras, views.picture = scene.CAMERAS, views._plain
    views.until("the views", lambda: len(views.page.marks()) == 4)
    views.until("no words", lambda: not views.page.page.is_visible("#no-views"))
