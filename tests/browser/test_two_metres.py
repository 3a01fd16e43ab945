"""The page is read by somebody who stands two metres away: large letters, the next step in sight, no empty room."""

from collections.abc import Iterator

import pytest

from common.messages.video import CameraStatus
from lab.measure.page.screenshots import STATES
from tests.browser.many_views import boxes
from tests.browser.told import Told, opened_told

SCREENS = ((1280, 720), (1920, 1080), (2560, 1440))
NARROW = ((390, 844), (820, 1180))
SIZE_OF = """(selector) =>
  Math.min(...[...document.querySelectorAll(selector)].map((e) => parseFloat(getComputedStyle(e).fontSize)))"""
MARKS = ".view .mark b, .view .mark span, .view .name, .view .fresh"
LEAST_AT_1080 = {"#reason": 24.0, "#state-word": 36.0, "#step-words": 24.0, MARKS: 18.0, "#alert": 20.0}
SCROLL = "() => { for (const id of ['side', 'room']) document.getElementById(id).scrollTop = 1e6; }"
IN_SIGHT = """() => ["step-words", "acts"].every((id) => {
  const { left, top, width, height } = document.getElementById(id).getBoundingClientRect();
  const [x, y] = [left + width / 2, top + height / 2];
  const seen = document.elementFromPoint(left + 12, y) ?? document.elementFromPoint(x, y);
  return height > 0 && top >= 0 && top + height <= innerHeight && seen !== null && seen.closest("#step") !== null;
})"""
GAPS = """() => {
  const step = document.getElementById("step");
  const lines = document.createRange();
  lines.selectNodeContents(document.getElementById("step-words"));
  const buttons = [...step.querySelectorAll("button")].filter((button) => button.checkVisibility());
  const shown = [...lines.getClientRects(), ...buttons.map((button) => button.getBoundingClientRect())];
  shown.sort((a, b) => a.top - b.top);
  const { top, bottom } = step.getBoundingClientRect();
  let at = top, widest = 0;
  for (const box of shown) { widest = Math.max(widest, box.top - at); at = Math.max(at, box.bottom); }
  return Math.max(widest, bottom - at) / parseFloat(getComputedStyle(document.documentElement).fontSize);
}"""
WORDS = {"ready": "disengaged", "another operates": "berta operates"}


@pytest.fixture(scope="module")
def told_here(browser: object) -> Iterator[Told]:
    """A page of its own, of a cell whose key is not held."""
    with opened_told(browser) as told:
        yield told


@pytest.fixture
def told(told_here: Told) -> Iterator[Told]:
    told_here.reset()
    told_here.describe(held=False)
    yield told_here
    told_here.page.resize(1280, 720)


def resize(told: Told, screen: tuple[int, int]) -> None:
    told.page.resize(screen[0], screen[1])
    told.tell()
    told.page.page.wait_for_timeout(100)


def in_sight(told: Told) -> None:
    """Wait until the step is in sight: on a busy machine its buttons may be gone for a moment, with the site silent."""
    told.until("the step in sight", lambda: bool(told.page.page.evaluate(IN_SIGHT)))


def sizes(told: Told) -> dict[str, float]:
    return {selector: float(told.page.page.evaluate(SIZE_OF, selector)) for selector in LEAST_AT_1080}


@pytest.mark.slow
def test_what_has_to_be_read_is_large_on_a_large_screen_and_grows_with_it(told: Told) -> None:
    told.until("a state", lambda: told.page.state() == "engaged")
    found = []
    for screen in SCREENS:
        resize(told, screen)
        found.append(sizes(told))
    small, middle, large = found
    assert {selector: size for selector, size in middle.items() if size < LEAST_AT_1080[selector]} == {}
    assert all(small[selector] < middle[selector] < large[selector] for selector in LEAST_AT_1080)


def test_a_mark_on_a_picture_is_as_large_as_the_rest(told: Told) -> None:
    told.troubles = {"side": (CameraStatus.DARK, "camera {} shows nothing: is there light, is its lens free?")}
    told.until("the mark", lambda: told.mark("side") == "dark")
    resize(told, (1920, 1080))
    assert float(told.page.page.evaluate(SIZE_OF, "[data-name=side] .mark span")) >= 18.0


@pytest.mark.slow
@pytest.mark.parametrize("screen", [*SCREENS, *NARROW])
def test_the_next_step_never_scrolls_out_of_sight(told: Told, screen: tuple[int, int]) -> None:
    page = told.page.page
    told.state = STATES["ready"]
    told.until("the step", lambda: page.is_visible("#engage"))
    page.evaluate("() => { for (const fold of document.querySelectorAll('#side details')) fold.open = true; }")
    resize(told, screen)
    in_sight(told)
    page.evaluate(SCROLL)
    assert (
        page.evaluate("() => document.getElementById('side').scrollTop + document.getElementById('room').scrollTop")
        > 100
    )
    in_sight(told)
    page.focus("#scale")
    in_sight(told)
    page.evaluate("() => { for (const id of ['side', 'room']) document.getElementById(id).scrollTop = 0; }")
    page.evaluate(
        "() => { for (const fold of document.querySelectorAll('#side details')) fold.open = fold.id === 'settings'; }"
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in STATES if name != "no robot"])
def test_no_room_is_left_empty_around_the_next_step(told: Told, name: str) -> None:
    told.state = STATES[name]
    told.until(
        "the word", lambda: told.page.state().startswith(WORDS.get(name, "engaged" if name == "limited" else name))
    )
    for screen in SCREENS[:2]:
        resize(told, screen)
        assert told.page.page.evaluate(GAPS) < 2.6, screen  # letters


@pytest.mark.slow
@pytest.mark.parametrize("screen", SCREENS)
def test_the_operators_own_views_are_as_wide_as_their_room(told: Told, screen: tuple[int, int]) -> None:
    told.previews = ("left", "right")
    told.until("a picture", lambda: "live" in told.page.words("#previews"))
    resize(told, screen)
    room = boxes(told, "#own")[0][2]
    assert sum(box[2] for box in boxes(told, "#previews .view")) >= 0.97 * room


@pytest.mark.slow
def test_large_type_is_on_one_key_remembered_and_listed(told: Told) -> None:
    page = told.page.page
    told.until("a state", lambda: told.page.state() == "engaged")
    usual = sizes(told)
    page.keyboard.press("l")
    told.tell()
    assert all(size >= 1.3 * usual[selector] for selector, size in sizes(told).items())
    assert page.get_attribute("#type", "aria-pressed") == "true"
    told.shot("large type")
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 1280
    page.reload()
    told.describe(held=False)
    told.until("a state", lambda: told.page.state() == "engaged")
    assert sizes(told)["#reason"] >= 1.3 * usual["#reason"]
    page.evaluate("() => { document.getElementById('keys').open = true; }")
    assert "large type" in page.inner_text("#keys")
    page.click("#type")
    del usual["#step-words"]  # the next step's size follows its length, and it is another one now
    told.until("the usual type", lambda: sizes(told).items() >= usual.items())
