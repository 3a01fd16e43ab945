"""The tool over the pictures: measured and sent are where the cameras see them, and the page says how late each is."""

from functools import partial

import numpy as np
import pytest
from msgspec.structs import replace

from common.geometry import Array
from common.messages.robot import SessionState
from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from tests.browser.late_remote import LateRemote
from tests.browser.opened_page import OpenedPage
from tests.browser.test_accessibility import CHECK
from tests.browser.told import Told

BEHIND = 6
APART = 70  # pixels of the full picture: nearer symbols cover each other in a small view
FIXED = ("front_high", "front_low", "side")
ON_TOOL = "gripper"
PROJECTIONS = {
    camera.name: np.reshape(camera.calibration.projection, (3, 4))
    for camera in scene.cell().cameras
    if camera.calibration is not None
}
RING, CROSS = 9, 11  # pixels from the middle at which each symbol has something on all four sides
MEASURED, SENT = (0x76, 0xBB, 0xFF), (0xFF, 0xD4, 0x79)
DRAWN = """([name, middle, out]) => {
  const canvas = document.querySelector(`[data-name=${name}] .tools`);
  const { width, height } = canvas;
  const scale = Math.min(width / 640, height / 480);
  const [x, y] = [(width - scale * 640) / 2 + scale * middle[0], (height - scale * 480) / 2 + scale * middle[1]];
  const near = (u, v) => [...canvas.getContext("2d").getImageData(Math.round(u) - 1, Math.round(v) - 1, 3, 3).data];
  return [[1, 0], [-1, 0], [0, 1], [0, -1]].map(([u, v]) => near(x + out * u, y + out * v));
}"""
LOOP_AND_SUGGESTION = "() => ['#loop', '#suggestion'].map((where) => document.querySelector(where).textContent)"
TAKE = "() => { const it = document.querySelector('#suggestion'), said = it.textContent; it.click(); return said; }"
AMBER = """(name) => {
  const canvas = document.querySelector(`[data-name=${name}] .tools`);
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let k = 0; k < data.length; k += 4) count += data[k] === 0xf5 && data[k + 1] === 0xb9 && data[k + 2] === 0x35;
  return count;
}"""
ANY = """(name) => {
  const canvas = document.querySelector(`[data-name=${name}] .tools`);
  return canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some((v) => v > 0);
}"""


def pixel(camera: str, base_T_tool: Array) -> Array:
    """Where a camera that stands in the cell sees the tool."""
    u, v, w = PROJECTIONS[camera] @ base_T_tool[:, 3]
    return np.array((u / w, v / w))


def is_drawn(told: Told, camera: str, middle: Array, out: int, tone: tuple[int, int, int]) -> bool:
    """Whether a symbol of this colour is drawn around a pixel of the full picture."""
    sides = told.page.page.evaluate(DRAWN, [camera, middle.tolist(), out])
    return all(_has(np.reshape(side, (9, 4)), tone) for side in sides)


def _has(pixels: Array, tone: tuple[int, int, int]) -> bool:
    return bool((np.abs(pixels[:, :3] - np.array(tone)).max(axis=1) < 24).any())


@pytest.fixture
def late(told: Told) -> LateRemote:
    """The page, told of a hand that has gone on since the state."""
    remote = LateRemote(BEHIND)
    told.hand, told.state = remote.hand, remote.state
    go_on(told, remote, 17)
    return remote


def go_on(told: Told, late: LateRemote, steps: int) -> None:
    """Let the hand move on by some samples, and stay there."""
    late.still = False
    for _ in range(steps):
        told.tell()
    late.still = True


def shows(told: Told, late: LateRemote, camera: str) -> bool:
    """Whether both symbols are where they belong now."""
    measured, sent = pixel(camera, late.measured), pixel(camera, late.sent)
    both = is_drawn(told, camera, measured, RING, MEASURED) and is_drawn(told, camera, sent, CROSS, SENT)
    return both and bool(np.linalg.norm(measured - sent) > APART)


@pytest.mark.slow
@pytest.mark.parametrize("camera", FIXED)
def test_measured_and_sent_are_where_the_camera_sees_them_and_differ_while_the_hand_moves(
    told: Told, late: LateRemote, camera: str
) -> None:
    told.until("both symbols", lambda: shows(told, late, camera))
    told.shot(f"tool marks {camera}")


def test_neither_is_drawn_where_the_operator_wants_none_or_the_picture_is_useless(told: Told, late: LateRemote) -> None:
    page = told.page.page
    told.until("both symbols", lambda: shows(told, late, "side"))
    page.keyboard.press("t")
    told.until("a plain picture", lambda: not page.evaluate(ANY, "side"))
    assert page.get_attribute("#marks", "aria-pressed") == "false"
    page.click("#marks")
    told.until("both symbols again", lambda: shows(told, late, "side"))
    told.age_ms = 1500.0
    told.until("a plain picture", lambda: not page.evaluate(ANY, "side"))


def test_what_is_sent_is_drawn_over_an_old_picture_as_over_a_new_one(told: Told, late: LateRemote) -> None:
    told.age_ms = 450.0
    told.until("both symbols", lambda: shows(told, late, "side"))
    told.until("the mark", lambda: told.mark("side") == "old")
    told.until("the age", lambda: " ms" in told.page.words("[data-name=side] .fresh"))


def test_the_marks_go_on_while_no_picture_comes(told: Told, late: LateRemote) -> None:
    told.age_ms = -60_000.0  # young enough for a minute, however slow the machine
    told.until("both symbols", lambda: shows(told, late, "side"))
    told.cameras, last = (), late.sent
    told.page.page.wait_for_timeout(200)
    before = told.page.pictures()[2]
    go_on(told, late, 10)
    told.until("both symbols elsewhere", lambda: shows(told, late, "side"))
    assert np.linalg.norm(pixel("side", late.sent) - pixel("side", last)) > APART
    assert told.page.pictures()[2] == before


def test_only_the_measured_tool_is_shown_while_the_arm_does_not_follow(told: Told, late: LateRemote) -> None:
    told.until("both symbols", lambda: shows(told, late, "side"))
    told.state = partial(scene.state, SessionState.HOLDING, "lost", "the hand is lost")
    tool = pixel("side", told.state().base_T_tool.transform())
    told.until("the measured tool", lambda: is_drawn(told, "side", tool, RING, MEASURED))
    told.until("nothing sent", lambda: told.page.words("#sent-age") == "–")
    assert not is_drawn(told, "side", pixel("side", late.sent), CROSS, SENT)
    assert told.page.words("#measured-age").endswith("ago")


def test_camera_on_the_tool_shows_the_measured_tool_where_it_always_is(told: Told) -> None:
    told.age_ms = 0.0  # as old as the state
    u, v, w = PROJECTIONS[ON_TOOL][:, 3]
    told.state = partial(scene.state, SessionState.HOLDING, "lost", "the hand is lost")
    told.until("the ring", lambda: is_drawn(told, ON_TOOL, np.array((u / w, v / w)), RING, MEASURED))


def scales(console: BareConsole) -> set[float]:
    """Every scale that was sent."""
    intents = [told.intent for told in console.intents if told.intent is not None]
    return {intent.settings.scale for intent in intents if intent.settings is not None}


@pytest.mark.slow
def test_the_scale_suggested_for_the_delay_is_taken_by_one_press_and_never_by_itself(browser: object) -> None:
    with BareConsole() as console:
        console.clock.round_trip_ms = 240.0
        told = Told(console, OpenedPage(browser, console.address))
        told.age_ms = 260.0
        told.describe()
        told.until("the round trip", lambda: told.page.words("#round-trip") == "240 ms")
        told.until("the suggestion", lambda: told.page.page.is_visible("#suggestion"))
        shown_ms, offered = told.page.page.evaluate(LOOP_AND_SUGGESTION)
        loop_ms, suggested = float(shown_ms.removesuffix(" ms")), float(offered.removeprefix("delay: use "))
        assert loop_ms >= 260.0 + 120.0
        assert suggested == pytest.approx(200.0 / loop_ms, abs=0.05)
        assert scales(console) == {1.0}
        told.shot("suggested scale")
        assert told.page.page.evaluate(CHECK)["poor"] == []
        taken = float(told.page.page.evaluate(TAKE).removeprefix("delay: use "))  # its median may change at any time
        told.until("the scale", lambda: len(scales(console)) == 2)
        assert min(scales(console)) == taken
        told.page.close()


def test_at_a_limit_an_arrow_shows_where_the_hand_gets_back(told: Told, late: LateRemote) -> None:
    told.until("both symbols", lambda: shows(told, late, "side"))
    told.state = lambda: replace(late.state(), code="outside_box", reason="the hand asks for 50 mm beyond")
    told.until("the limit", lambda: told.page.words("#state-second") == "at the workspace's edge")
    told.until("the arrow", lambda: told.page.page.evaluate(AMBER, "side") > 100)
    told.shot("limit arrow")
    told.state = late.state
    told.until("no arrow", lambda: told.page.page.evaluate(AMBER, "side") == 0)
