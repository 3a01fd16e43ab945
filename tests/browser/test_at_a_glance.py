"""What the page says at a glance: one colour for what the arm does, one thing to do next, pictures first."""

from functools import partial

import numpy as np
import pytest
from msgspec.structs import replace

from common.messages.hand import Locks, OperatorSettings
from common.messages.robot import Pose, Readiness, SessionState
from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from lab.measure.page.screenshots import STATES, anothers
from local_site.console.hub import Hub
from tests.browser.late_remote import LateRemote
from tests.browser.opened_page import OpenedPage
from tests.browser.told import Told

ENGAGED, HOLDING = SessionState.ENGAGED, SessionState.HOLDING
BELOW = """() => {
  const box = (id) => document.getElementById(id).getBoundingClientRect();
  const [words, acts, alert] = ["step-words", "acts", "alert"].map(box);
  return [Math.max(words.bottom, acts.bottom), alert.top];
}"""
FOLLOWS, LOST = "the arm follows the hand", "the hand is lost"
SHARE = """() => {
  const views = [...document.querySelectorAll("#cameras .view")].map((view) => view.getBoundingClientRect());
  const area = views.reduce((sum, box) => sum + box.width * box.height, 0);
  const bars = views.map((box) => Math.abs(box.width / box.height - 4 / 3));
  const wide = document.documentElement.scrollWidth;
  return { share: area / (innerWidth * innerHeight), bars: Math.max(...bars), wide };
}"""
SMALLEST = """() => Math.min(...[...document.querySelectorAll("body *")]
  .filter((e) => e.checkVisibility() && [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()))
  .map((e) => parseFloat(getComputedStyle(e).fontSize)))"""
WORDS_SEEN = """() => {
  window.seen = [];
  new MutationObserver(() => window.seen.push(document.getElementById("state-word").textContent))
    .observe(document.getElementById("state-word"), { childList: true, characterData: true, subtree: true });
}"""


def tone(told: Told) -> str:
    return str(told.page.page.get_attribute("body", "data-tone"))


def listed(told: Told) -> list[str]:
    """The events on the page."""
    return list(told.page.page.locator("#events li").all_text_contents())


def ranked(told: Told, rank_: str) -> list[str]:
    return list(
        told.page.page.eval_on_selector_all(f"#acts > [data-rank={rank_}]", "(found) => found.map((one) => one.id)")
    )


@pytest.mark.parametrize(
    ("name", "expected", "next_"),
    [
        ("engaged", "engaged", []),
        ("limited", "holding", []),
        ("holding", "holding", []),
        ("ready", "idle", ["engage"]),
        ("stopped", "fault", ["reset"]),
        ("fault", "fault", ["reset"]),
        ("another operates", "other", ["lease-button"]),
    ],
)
def test_a_state_has_one_colour_and_at_most_one_thing_to_do_next(
    told: Told, name: str, expected: str, next_: list[str]
) -> None:
    told.describe(held=False)
    told.state = STATES[name]
    told.until("the colour", lambda: tone(told) == expected and ranked(told, "next") == next_)
    assert told.page.words("#step-words") != ""
    told.describe()


def test_where_a_key_has_to_be_held_it_is_the_next_thing_once_all_is_ready(told: Told) -> None:
    told.state = partial(
        scene.state, SessionState.DISENGAGED, "not_held", "not held", readiness=Readiness(True, "ready", "ready", False)
    )
    told.until("the key", lambda: ranked(told, "next") == ["hold"])
    missing = Readiness(False, "no_hand", "no hand sample has arrived yet", False)
    told.state = partial(scene.state, SessionState.DISENGAGED, "no_hand", "no hand", readiness=missing)
    told.until("what is missing", lambda: "no hand sample has arrived" in told.page.words("#step-words"))
    assert ranked(told, "next") == ["hold"]
    assert told.page.page.get_attribute("#hold", "data-waits") == "true"


def test_a_key_that_is_down_though_the_arm_does_not_follow_is_to_be_let_go_first(told: Told) -> None:
    told.age_ms = -60_000.0  # live, however slow the machine: what is not would be said first
    told.state = partial(
        scene.state, SessionState.DISENGAGED, "let_go", "let go", readiness=Readiness(True, "ready", "ready", False)
    )
    told.until("the key", lambda: ranked(told, "next") == ["hold"])
    assert "Let go" not in told.page.words("#step-words")
    told.page.page.keyboard.down("Space")
    told.until("what to do", lambda: told.page.words("#step-words").startswith("Let go first"))
    told.page.page.keyboard.up("Space")
    told.until("the key again", lambda: told.page.words("#step-words").startswith("Hold"))


def test_the_lease_is_not_offered_while_the_local_site_that_takes_it_is_silent(told: Told) -> None:
    told.state = partial(scene.state, SessionState.DISENGAGED, "not_engaged", "not engaged yet", lease=None)
    told.until("the lease", lambda: ranked(told, "next") == ["lease-button"])
    told.is_hand_told = False
    told.until("what to start", lambda: "farhand local" in told.page.words("#step-words"))
    assert ranked(told, "next") == []


@pytest.mark.slow
def test_a_page_without_a_live_picture_says_so_beside_what_comes_next(told: Told) -> None:
    told.until("pictures", lambda: "No live picture" not in told.page.words("#step-words"))
    told.cameras = ()
    told.until("the warning", lambda: told.page.words("#step-words").startswith("No live picture of the cell."))
    told.reset()
    told.until("pictures again", lambda: "No live picture" not in told.page.words("#step-words"))


def test_a_view_that_is_not_live_is_named_first_though_others_are(told: Told) -> None:
    told.state = STATES["ready"]
    told.age_ms = -60_000.0
    told.until("nothing wrong", lambda: told.page.words("#step-words").startswith("Hold"))
    told.picture = lambda camera, seq: scene.picture(
        camera, seq, told.jpeg, age_ms=4000.0 if camera == "side" else -60_000.0
    )
    told.until("the view", lambda: told.page.words("#step-words").startswith("Look out: side is "))
    assert "s old. Wait for live pictures, or hold only if you see the arm itself." in told.page.words("#step-words")


def test_at_a_limit_the_way_back_is_said_in_words(told: Told) -> None:
    late = LateRemote(0)
    told.age_ms = -60_000.0
    told.hand, told.state = late.hand, lambda: replace(late.state(), code="outside_box", reason="beyond the workspace")
    for _ in range(8):
        told.tell()
    late.still = True
    told.until("the way back", lambda: told.page.words("#step-words").startswith("Move your hand "))
    told.until("its direction", lambda: "back the way it came" not in told.page.words("#step-words"))


@pytest.mark.slow
def test_a_refusal_hides_neither_the_next_step_nor_its_button_and_goes_by_itself(told: Told) -> None:
    told.sites.silent = True
    told.until("the button", lambda: told.page.page.is_visible("#disengage"))
    told.page.page.keyboard.press("c")
    told.page.page.keyboard.press("d")
    told.until("the refusal", lambda: "nobody answers" in told.page.words("#alert"))
    bottom, top = told.page.page.evaluate(BELOW)
    assert bottom <= top
    told.sites.silent = False
    told.until("its end", lambda: not told.page.page.is_visible("#alert"))


def test_a_tool_far_from_its_target_is_behind_and_locks_are_named(told: Told) -> None:
    q = scene.CONFIG.robot.start
    far = Pose.from_transform(scene.MODEL.forward(q + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.8])))
    told.state = partial(scene.state, ENGAGED, "ok", FOLLOWS, target=far)
    told.until("the second line", lambda: told.page.words("#state-second") == "behind the hand")
    assert told.page.state() == "engaged"
    assert "46° from its target" in told.page.words("#reason")
    assert tone(told) == "holding"
    locked = OperatorSettings(lease=5, locks=Locks(x=True, yaw=True))
    told.state = partial(scene.state, ENGAGED, "ok", FOLLOWS, settings=locked)
    told.until("the locks", lambda: "locked: x, yaw" in told.page.words("#reason"))
    assert tone(told) == "engaged"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "second"),
    [
        ("out_of_reach", "at its reach"),
        ("ik_limit", "at a joint limit"),
        ("obstacle", "at an obstacle"),
        ("workspace", "at the workspace's edge"),
        ("velocity", "at its speed limit"),
        ("singular", "near a singular posture"),
        ("of a later release", "at a limit"),
    ],
)
def test_the_big_word_is_what_the_arm_does_and_the_limit_stands_below_it(told: Told, code: str, second: str) -> None:
    told.state = partial(scene.state, ENGAGED, code, "the arm is at a limit")
    told.until("the limit", lambda: told.page.words("#state-second") == second)
    assert told.page.state() == "engaged"
    assert tone(told) == "holding"


@pytest.mark.slow
def test_before_anything_was_started_nothing_is_wrong_and_the_page_says_what_to_type(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, console.address)
        page.wait_for("the word", lambda: page.state() == "no robot")
        assert page.page.get_attribute("body", "data-tone") == "idle"
        said = page.page.inner_text("#no-views")
        assert "farhand remote --config remote.toml" in said
        assert "farhand local --config local.toml" in said
        assert "emergency stop" in page.words("#step-words")
        told = Told(console, page)
        told.give(Hub.hand, scene.hand())
        page.wait_for("the hand", lambda: "farhand local" not in page.words("#no-views"))
        assert "farhand remote" in page.words("#no-views")
        told.describe()
        told.until("the robot", lambda: page.state() == "engaged" and not page.page.is_visible("#no-views"))
        page.wait_for("silence, which is wrong", lambda: page.page.get_attribute("body", "data-tone") == "fault")
        page.close()


@pytest.mark.slow
def test_a_telephone_is_shown_no_keys_and_a_computer_is(told: Told, browser: object) -> None:
    kbd = "() => [...document.querySelectorAll('kbd')].filter((key) => key.checkVisibility()).length"
    told.until("a state", lambda: told.page.state() == "engaged")
    assert told.page.page.evaluate(kbd) == 0  # its screen is touched
    assert told.page.page.is_visible("#stop")
    plain = browser.new_context().new_page()  # type: ignore[attr-defined]
    plain.goto(told.page.page.url)
    plain.wait_for_selector("#stop kbd")
    assert plain.evaluate(kbd) >= 3
    plain.context.close()


@pytest.mark.slow
def test_ghost_and_tool_are_switched_off_by_one_button_each_and_stay_so(told: Told) -> None:
    page = told.page.page
    for button, key in (("ghost", "g"), ("marks", "t")):
        page.keyboard.press(key)
        page.reload()
        told.describe()
        told.until("the buttons", lambda: page.is_visible("#overlays"))
        assert page.get_attribute(f"#{button}", "aria-pressed") == "false"
        page.click(f"#{button}")
        assert page.get_attribute(f"#{button}", "aria-pressed") == "true"


def test_while_another_operates_the_page_says_that_the_hand_moves_nothing(told: Told) -> None:
    told.state = anothers
    told.until("the word", lambda: told.page.state() == "berta operates")
    assert "your hand moves nothing" in told.page.words("#reason")
    assert tone(told) == "other"


@pytest.mark.slow
def test_a_state_that_changes_many_times_a_second_does_not_flicker(told: Told) -> None:
    told.until("the arm follows", lambda: tone(told) == "engaged")
    told.page.page.evaluate(WORDS_SEEN)
    for k in range(40):
        word, code, reason = (HOLDING, "lost", LOST) if k % 2 else (ENGAGED, "ok", FOLLOWS)
        told.state = partial(scene.state, word, code, reason)
        told.tell()
        told.page.page.wait_for_timeout(60)
    assert told.page.page.evaluate("() => window.seen") == ["holding"]
    told.state = partial(scene.state, ENGAGED, "ok", FOLLOWS)
    told.until("the arm follows again", lambda: tone(told) == "engaged")


def test_the_first_cause_stays_in_sight_until_it_is_answered(told: Told) -> None:
    dead = "the robot's driver has ended; reset it, then engage"
    told.state = partial(
        scene.state, SessionState.FAULT, "fault", dead, readiness=Readiness(False, "fault", dead, False)
    )
    told.until("the fault", lambda: told.page.state() == "fault")
    told.page.wait_for("the silence after it", lambda: "has been silent" in told.page.words("#reason"))
    told.page.wait_for("no round trip", lambda: told.page.words("#round-trip") == told.page.words("#loop") == "–")
    assert told.page.state() == "fault"
    assert told.page.words("#reason").startswith("the robot's driver has ended")
    told.page.wait_for("the event", lambda: any("fallen silent" in event for event in listed(told)))
    told.state = partial(scene.state, SessionState.DISENGAGED, "ok", "press Engage", session=2)
    told.until("the site that came after", lambda: told.page.state() == "disengaged")
    assert told.page.words("#reason").startswith(
        f"the remote site has started again, and knows nothing of this any more: {dead}"
    )
    told.state = partial(scene.state, ENGAGED, "ok", FOLLOWS)
    told.until("the answer", lambda: told.page.state() == "engaged")
    told.until("nothing left to answer", lambda: dead not in told.page.words("#reason"))
    told.until("the news", lambda: any("answers again" in event for event in listed(told)))


@pytest.mark.parametrize(("width", "height"), [(1920, 1080), (1280, 720), (2560, 1440)])
def test_the_views_take_two_thirds_of_the_screen_and_have_no_bars(told: Told, width: int, height: int) -> None:
    told.page.page.evaluate("() => document.querySelector('#cameras .enlarged')?.click()")
    told.page.resize(width, height)
    found = told.page.page.evaluate(SHARE)
    told.page.resize(1280, 720)
    assert found["share"] >= 0.65
    assert found["bars"] < 0.02
    assert found["wide"] <= width


@pytest.mark.parametrize("width", [390, 820, 1280, 1920, 2560])
def test_no_word_is_smaller_than_twelve_pixels_and_nothing_lies_beyond_the_side(told: Told, width: int) -> None:
    told.page.resize(width, 900)
    told.until("a state", lambda: told.page.state() == "engaged")
    smallest, wide = told.page.page.evaluate(SMALLEST), told.page.page.evaluate(SHARE)["wide"]
    told.page.resize(1280, 720)
    assert smallest >= 12.0
    assert wide <= width


def test_dark_or_light_and_the_tones_are_remembered(told: Told) -> None:
    page = told.page.page
    told.page.wear("dark")
    page.click("#theme")
    page.keyboard.press("m")
    kept = page.evaluate("() => [localStorage.getItem('farhand-theme'), localStorage.getItem('farhand-tones')]")
    assert kept == ["light", "off"]
    assert page.get_attribute("#tones", "aria-pressed") == "false"
    page.click("#theme")
    page.keyboard.press("m")
    assert page.get_attribute("html", "data-theme") == "dark"


def test_the_robot_is_named_without_its_files_path(told: Told) -> None:
    urdf = "/opt/cell/models/long_arm.urdf"
    told.give(lambda hub, cell: hub.described(cell), replace(scene.cell(), robot=urdf))
    told.until("its name", lambda: told.page.words("#cell").endswith("long_arm · simulated"))
    told.describe()
