"""A key acts only while its button is shown; Esc stops on every page, in every state and at every size."""

import time
from collections.abc import Callable, Iterator
from functools import partial

import pytest
from msgspec.structs import replace

from common.messages.requests import EngagementAction
from common.messages.robot import Readiness, RobotState, SessionState
from lab.measure.page import scene
from lab.measure.page.screenshots import STATES
from local_site.console.hub import Hub
from tests.browser.opened_page import READING_MS, OpenedPage
from tests.browser.told import Told, opened_told

STOP = EngagementAction.STOP
ASLEEP = "the robot is not ready: stopped, not active any more; reset it, then engage"
SLEEPS = partial(
    scene.state,
    SessionState.DISENGAGED,
    "robot_not_ready",
    ASLEEP,
    readiness=Readiness(False, "robot_not_ready", ASLEEP, False),
)
CLUTCHED = partial(scene.state, SessionState.HOLDING, "clutched", "the clutch is held: the arm stays")
SHOWN: dict[str, tuple[Callable[..., RobotState | None], str]] = {
    "fault": (STATES["fault"], "r"),
    "stopped": (STATES["stopped"], "r"),
    "robot stopped by itself": (SLEEPS, "r"),
    "ready": (STATES["ready"], "e"),
    "engaged": (STATES["engaged"], "dn"),
    "holding": (STATES["holding"], "dn"),
    "clutched": (CLUTCHED, "dn"),
    "another operates": (STATES["another operates"], "o"),
}
SIZES = ((1920, 1080), (390, 844), (320, 120), (60, 60))
SENT = """() => {
  window.sent = [];
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (text) { window.sent.push(JSON.parse(text)); send.call(this, text); };
}"""
AS_KEYS = """() => window.sent.splice(0).filter(({ type }) => ["ask", "ask_lease", "new_origins"].includes(type))
  .map(({ type, action }) => ({ new_origins: "n", ask_lease: "o" })[type] ?? action[0])"""
CLUTCHES = "() => window.sent.splice(0).filter(({ type }) => type === 'beat').map(({ clutch }) => clutch)"
DOWN = """() => window.sent.splice(0)
  .some(({ type, down, assist, clutch }) => type === "beat" && (down || assist !== null || clutch !== "up"))"""
PRESSED = "(id) => document.getElementById(id).getAttribute('aria-pressed')"


@pytest.fixture(scope="module")
def told_here(browser: object) -> Iterator[Told]:
    """A page of its own: what it sends is overheard."""
    with opened_told(browser) as told:
        told.page.page.evaluate(SENT)
        yield told


@pytest.fixture
def overheard(told_here: Told) -> Told:
    told_here.reset()
    told_here.describe(held=False)
    return told_here


def shows(told: Told, name: str) -> None:
    """Tell this state until the page shows it, with the buttons that belong to it."""
    told.state, keys = SHOWN[name]
    ids = {"r": "reset", "e": "engage", "d": "disengage", "n": "origins", "o": "lease-button"}
    shown = "(ids) => ids.filter((id) => document.getElementById(id).checkVisibility())"
    buttons = {ids[key] for key in keys}
    told.until("its buttons", lambda: set(told.page.page.evaluate(shown, list(ids.values()))) == buttons)


def pressed(told: Told, keys: str) -> str:
    """Which of these keys had the page ask for something."""
    told.page.page.evaluate(AS_KEYS)
    for key in keys:
        told.page.page.keyboard.press(key)
    return "".join(told.page.page.evaluate(AS_KEYS))


@pytest.mark.slow
@pytest.mark.parametrize("name", SHOWN)
def test_a_key_acts_only_while_its_button_is_shown(overheard: Told, name: str) -> None:
    shows(overheard, name)
    assert sorted(pressed(overheard, "edrnoEDRNO")) == sorted(2 * SHOWN[name][1])


def test_in_a_fault_e_engages_nothing_however_often_it_is_pressed(overheard: Told) -> None:
    shows(overheard, "fault")
    asked = overheard.sites.asked
    asked.clear()
    for _ in range(3):
        overheard.page.page.keyboard.press("e")
        overheard.page.page.wait_for_timeout(50)
    overheard.page.page.keyboard.press("r")
    overheard.until("the reset", lambda: bool(asked))
    assert asked == [EngagementAction.RESET]


@pytest.mark.slow
def test_a_reset_names_what_can_have_been_read_and_an_engagement_what_is_shown(overheard: Told) -> None:
    """A stop that comes while the operator reaches for R is not cleared by it."""
    page, asked = overheard.page.page, overheard.sites.asked
    first, second = 4611686018427387903, 4611686018427387904  # JavaScript takes both for one number

    def shows_halt(code: str, reason: str, halted_ns: int) -> None:
        readiness = Readiness(code != "stopped", code, reason, False)
        overheard.state = partial(
            scene.state, SessionState.DISENGAGED, code, reason, readiness=readiness, halted_ns=halted_ns
        )
        overheard.until("the reason", lambda: reason in overheard.page.words("#reason"))

    def is_read() -> None:
        ends = time.monotonic() + READING_MS / 1000
        overheard.until("time to read it", lambda: time.monotonic() > ends)

    def seen_with(key: str) -> int:
        asked.clear()
        page.keyboard.press(key)
        overheard.until("the request", lambda: bool(asked))
        return overheard.sites.seen_ns

    shows_halt("stopped", "stopped by anna", first)
    is_read()
    shows_halt("stopped", "stopped by maintenance and anna", second)
    assert seen_with("r") == first
    is_read()
    assert seen_with("r") == second
    shows_halt("released", "disengaged on request", second + 1)
    assert seen_with("e") == second + 1


def test_a_page_that_only_watches_asks_for_nothing(overheard: Told) -> None:
    shows(overheard, "ready")
    overheard.page.page.click("#seat-button")
    overheard.until("the seat left", lambda: overheard.page.page.is_disabled("#engage"))
    assert pressed(overheard, "edrnoc") == ""
    overheard.page.page.click("#seat-button")
    overheard.until("the seat", lambda: overheard.page.page.is_enabled("#engage"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "key"), [("fault", "Space"), ("stopped", "Space"), ("ready", "Space"), ("fault", "a"), ("ready", "c")]
)
def test_what_is_held_counts_only_where_its_button_was_shown_when_it_went_down(
    overheard: Told, name: str, key: str
) -> None:
    overheard.describe(held=name != "ready")
    shows(overheard, name)
    page = overheard.page.page
    page.evaluate(DOWN)
    page.keyboard.down(key)
    page.wait_for_timeout(150)
    page.keyboard.up(key)
    assert not page.evaluate(DOWN)


def test_keys_of_what_is_not_drawn_do_nothing(overheard: Told) -> None:
    """Nothing is drawn over pictures of which none is calibrated."""
    shows(overheard, "ready")
    page, cell = overheard.page.page, scene.cell(held=False)
    bare = replace(cell, cameras=tuple(replace(camera, calibration=None) for camera in cell.cameras))
    for key, button in (("g", "ghost"), ("t", "marks")):
        page.keyboard.press(key)
        assert page.evaluate(PRESSED, button) == "false"
        page.keyboard.press(key)
        overheard.give(Hub.described, bare)
        overheard.until("no buttons", lambda: not page.is_visible("#overlays"))
        page.keyboard.press(key)
        assert page.evaluate(PRESSED, button) == "true"
        overheard.give(Hub.described, cell)
        overheard.until("the buttons", lambda: page.is_visible("#overlays"))


def test_keys_of_a_replay_do_nothing_on_a_live_page(overheard: Told) -> None:
    shows(overheard, "ready")
    overheard.page.page.keyboard.press(" ")
    overheard.page.page.keyboard.press("ArrowRight")
    assert "play" not in {told["type"] for told in overheard.page.page.evaluate("() => window.sent")}


def stops(told: Told) -> bool:
    """Whether Esc has the console ask for a stop, and the page show that it is acknowledged."""
    told.sites.asked.clear()
    told.page.page.keyboard.press("Escape")
    told.until("the stop", lambda: STOP in told.sites.asked)
    told.until("the acknowledgement", lambda: "acknowledged" in told.page.words("#alert"))
    return told.sites.asked == [STOP]


@pytest.mark.slow
@pytest.mark.parametrize("name", SHOWN)
def test_escape_stops_in_every_state(overheard: Told, name: str) -> None:
    shows(overheard, name)
    assert stops(overheard)


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
def test_escape_stops_at_every_size_whether_or_not_its_button_is_in_sight(
    overheard: Told, size: tuple[int, int]
) -> None:
    page = overheard.page.page
    overheard.page.resize(size[0], size[1])
    page.evaluate("() => scrollTo(0, document.body.scrollHeight)")
    assert stops(overheard)
    overheard.page.resize(1280, 720)


AT = {
    "a slider": lambda page: page.focus("#scale"),
    "the drawing of the arm": lambda page: page.focus("#arm"),
    "the list of events": lambda page: page.evaluate(
        "() => { document.getElementById('events-room').open = true; document.getElementById('events').focus(); }"
    ),
    "a button": lambda page: page.focus("#theme"),
    "a key that is held": lambda page: page.keyboard.down("Space"),
    "the shift key": lambda page: page.keyboard.down("Shift"),
    "control": lambda page: page.keyboard.down("Control"),
    "a view that fills the page": lambda page: page.keyboard.press("1"),
    "a dialog that is open": lambda page: page.evaluate(
        "() => { const open = document.createElement('dialog'); document.body.append(open); open.showModal(); }"
    ),
    "a field to write in": lambda page: page.evaluate(
        "() => { const field = document.createElement('input'); document.body.append(field); field.focus(); }"
    ),
    "its button is not drawn": lambda page: page.evaluate(
        "() => { document.getElementById('stop').style.display = 'none'; }"
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("at", AT)
def test_escape_stops_wherever_the_operator_is(browser: object, at: str) -> None:
    with opened_told(browser) as told:
        AT[at](told.page.page)
        assert stops(told)


def test_escape_that_was_down_before_the_page_had_the_keyboard_stops_once(overheard: Told) -> None:
    shows(overheard, "engaged")
    overheard.sites.asked.clear()
    repeat = "() => dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', repeat: true }))"
    for _ in range(5):
        overheard.page.page.evaluate(repeat)
    overheard.until("the stop", lambda: STOP in overheard.sites.asked)
    overheard.page.page.wait_for_timeout(100)
    assert overheard.sites.asked == [STOP]
    overheard.page.page.evaluate("() => dispatchEvent(new KeyboardEvent('keyup', { key: 'Escape' }))")


@pytest.mark.slow
def test_escape_stops_on_a_page_that_only_watches(overheard: Told, browser: object) -> None:
    watching = OpenedPage(browser, overheard.page.page.url)
    watching.wait_for("the word", lambda: "you watch" in watching.words("#seat"))
    overheard.sites.asked.clear()
    watching.page.keyboard.press("Escape")
    overheard.until("the stop", lambda: overheard.sites.asked == [STOP])
    watching.close()


@pytest.mark.slow
@pytest.mark.parametrize("robot", [None, "silent"])
def test_escape_stops_without_a_state_of_the_remote_site(browser: object, robot: str | None) -> None:
    with opened_told(browser) as told:
        told.sites.asked.clear()
        if robot is None:
            told.page.page.reload()
        told.page.wait_for("the word", lambda: told.page.state() in ("no robot", "silent"))
        told.page.page.keyboard.press("Escape")
        told.page.wait_for("the stop", lambda: told.sites.asked == [STOP])


def clutched(told: Told, key: str) -> None:
    """Show the state until every beat reports the clutch so."""
    told.page.page.evaluate(CLUTCHES)
    told.until(f"the clutch {key}", lambda: set(told.page.page.evaluate(CLUTCHES)) == {key})


@pytest.mark.slow
@pytest.mark.parametrize("by", ["key", "button"])
def test_the_clutch_is_down_while_it_is_held_and_what_is_next_is_said(overheard: Told, by: str) -> None:
    shows(overheard, "engaged")
    page = overheard.page.page
    if by == "key":
        page.keyboard.down("c")
    else:
        page.hover("#clutch")
        page.mouse.down()
    clutched(overheard, "down")
    overheard.state = CLUTCHED
    overheard.until("the word", lambda: overheard.page.state() == "clutched")
    assert "then let go of the clutch" in overheard.page.words("#step-words")
    assert page.get_attribute("#clutch", "data-rank") == "next"
    clutched(overheard, "down")
    if by == "key":
        page.keyboard.up("c")
    else:
        page.mouse.up()
    clutched(overheard, "up")


@pytest.mark.parametrize(
    "unseen",
    ["dispatchEvent(new Event('blur'))", "document.dispatchEvent(new Event('visibilitychange'))"],
    ids=["blur", "hidden"],
)
def test_a_clutch_that_the_page_did_not_see_let_go_stays_until_it_is_pressed_again_and_let_go(
    overheard: Told, unseen: str
) -> None:
    shows(overheard, "clutched")
    page = overheard.page.page
    page.keyboard.down("c")
    clutched(overheard, "down")
    page.evaluate(f"() => {{ {unseen}; }}")
    clutched(overheard, "unseen")
    page.keyboard.up("c")
    clutched(overheard, "unseen")
    page.keyboard.down("c")
    clutched(overheard, "down")
    page.keyboard.up("c")
    clutched(overheard, "up")


def test_a_clutch_whose_release_nobody_saw_can_be_pressed_again_while_disengaged(overheard: Told) -> None:
    why = "nobody saw the clutch let go"
    readiness = Readiness(False, "clutch_unseen", why, False)
    overheard.state = partial(scene.state, SessionState.DISENGAGED, "latched", why, readiness=readiness)
    overheard.until("the next step", lambda: "press it, let go, engage" in overheard.page.words("#step-words"))
    overheard.page.page.keyboard.down("c")
    clutched(overheard, "down")
    overheard.page.page.keyboard.up("c")
    clutched(overheard, "up")


def test_a_stop_leaves_the_clutch_as_it_is_held(overheard: Told) -> None:
    shows(overheard, "clutched")
    overheard.page.page.keyboard.down("c")
    assert stops(overheard)
    clutched(overheard, "down")
    overheard.page.page.keyboard.up("c")
    clutched(overheard, "up")
