"""What the page shows of its messages, without sites: states, faulty cameras, ghost, trace, lease, clocks."""

import time
from functools import partial
from pathlib import Path

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.messages.robot import (
    Asker,
    GripperCommand,
    GripperState,
    GripperStatus,
    LeaseState,
    Readiness,
    SessionState,
)
from common.messages.video import CameraStatus, VideoFrame
from lab.measure.page import scene
from lab.measure.page.bare_console import OPERATOR, BareConsole
from lab.measure.page.painted_clock import ages_ms, compare, watch
from lab.stage.clock_strip import draw_clock
from local_site.console.hub import Hub
from remote_site.video.streaming.pictures import encode_jpeg
from tests.browser.opened_page import OpenedPage
from tests.browser.told import Told
from tests.present import present

OPEN, CLOSED, KEEP = GripperCommand.OPEN, GripperCommand.CLOSED, GripperCommand.KEEP
CHECK = (Path(__file__).parent / "accessibility.js").read_text().split("\n", 1)[1]
ASKERS_SESSION = 4611686018427387903  # JavaScript would round it
BOX = "the workspace box holds the tool back: move the hand down"
LOST = "the hand is not tracked: keep forearm and hand in both views"
BROKEN = "the robot reports a fault: following error of joint_3; reset it once the cause is gone"
STATES = {
    "engaged": (SessionState.ENGAGED, "ok", "the arm follows the hand", "engaged", "light"),
    "limited": (SessionState.ENGAGED, "outside_box", BOX, "engaged", "dark"),
    "holding": (SessionState.HOLDING, "lost", LOST, "holding", "light"),
    "disengaged": (SessionState.DISENGAGED, "let_go", "the key was let go", "disengaged", "light"),
    "fault": (SessionState.FAULT, "robot", BROKEN, "fault", "dark"),
}
SEND_LATE = """ms => {
  const send = (window.sendNow ??= WebSocket.prototype.send);
  WebSocket.prototype.send = ms === 0 ? send : function (message) { setTimeout(() => send.call(this, message), ms); };
}"""
COUNT_MARKS = """() => {
  window.marksChanged = 0;
  const changed = new MutationObserver((seen) => (window.marksChanged += seen.length));
  changed.observe(document.querySelector("[data-name=side]"), { attributeFilter: ["data-mark"] });
}"""
TROUBLES = {
    CameraStatus.DARK: "camera {} shows nothing: is there light, is its lens free?",
    CameraStatus.FROZEN: "camera {} has given no new picture for 0.6 s; check its cable, its power and its address",
    CameraStatus.MISSING: "camera {} cannot be opened: check its cable",
    CameraStatus.SLOW: "camera {} gives 5.0 of 30 pictures a second; check its exposure time and its cable",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", STATES)
def test_every_state_is_told_in_words_with_its_reason_and_can_be_read(told: Told, name: str) -> None:
    state, code, reason, word, scheme = STATES[name]
    told.state = partial(scene.state, state, code, reason, readiness=Readiness(True, code, reason, True))
    told.page.wear(scheme)
    told.until("the word", lambda: told.page.state() == word and reason in told.page.words("#reason"))
    told.until(
        "the event", lambda: any(reason in event for event in told.page.page.locator("#events li").all_text_contents())
    )
    found = told.page.page.evaluate(CHECK)
    told.shot(f"{name}-{scheme}")
    assert found["poor"] == []
    assert (told.page.page.get_attribute("#reset", "data-rank") == "next") == (name == "fault")


@pytest.mark.slow
def test_each_camera_in_trouble_is_called_what_it_is_and_why(told: Told) -> None:
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    told.troubles = dict(zip(scene.CAMERAS, TROUBLES.items(), strict=True))
    found = {camera: status.value for camera, (status, _) in told.troubles.items()}
    told.until("the marks", lambda: {c: told.mark(c) for c in scene.CAMERAS} == found)
    for camera, (status, reason) in told.troubles.items():
        words = f"[data-name={camera}] .mark"
        assert reason.format(camera) in told.page.words(words), status
        assert told.page.page.is_visible(words)
    told.until("an old picture", lambda: "s old" in told.page.words("[data-name=front_low] .mark"))
    told.shot("faulty cameras")
    assert told.page.page.evaluate(CHECK)["poor"] == []


@pytest.mark.slow
def test_a_picture_that_was_taken_long_ago_never_looks_live(told: Told) -> None:
    told.until("a view without a mark", lambda: not told.page.page.is_visible("[data-name=side] .mark"))
    told.age_ms = 400.0
    told.until("the marks", lambda: set(told.page.marks()) == {"old"})
    told.until("the age", lambda: "ms old" in told.page.words("[data-name=side] .mark"))
    told.shot("old pictures")


GHOST = """(name) => {
  const canvas = document.querySelector(`[data-name=${name}] .ghost`);
  const { width, height } = canvas;
  const drawn = canvas.getContext("2d").getImageData(0, 0, width, height).data;
  const points = [];
  for (let k = 0; k < width * height; k++) {
    if (drawn[4 * k + 3] > 200 && drawn[4 * k] > 150) points.push([k % width, Math.floor(k / width)]);
  }
  return { points, width, height };
}"""


def ghost(told: Told, camera: str) -> np.ndarray:
    """Where the ghost is drawn, in pixels of the full picture."""
    found = told.page.page.evaluate(GHOST, camera)
    height, width = scene.SIZE
    scale = min(found["width"] / width, found["height"] / height)
    margin = (np.array([found["width"], found["height"]]) - scale * np.array([width, height])) / 2
    return np.asarray((np.array(found["points"]).reshape(-1, 2) + 0.5 - margin) / scale)


def ghosts_drawn(told: Told, camera: str) -> np.ndarray:
    """Where the ghost is drawn, once it is; a busy machine's pictures may be too old for it for a while."""
    drawn: list[np.ndarray] = []
    told.until(f"the ghost in {camera}", lambda: drawn.append(ghost(told, camera)) or len(drawn[-1]) > 50)
    return drawn[-1]


@pytest.mark.slow
def test_the_ghost_is_the_commanded_arm_where_the_camera_sees_it(told: Told) -> None:
    told.until("the ghost", lambda: len(ghost(told, "side")) > 50)
    calibrations = {camera.name: camera.calibration for camera in scene.cell().cameras}
    q = present(told.state()).q_commanded
    for camera in ("front_high", "front_low", "side"):
        projection = np.reshape(present(calibrations[camera]).projection, (3, 4))
        u, v, w = projection @ [*scene.MODEL.position(np.array(q)), 1.0]
        drawn = ghosts_drawn(told, camera)
        assert np.linalg.norm(drawn - (u / w, v / w), axis=1).min() < 3.0, camera
    assert told.page.page.inner_text("[data-name=side] .explains") == "violet: the arm as commanded"
    told.shot("ghost")
    told.page.page.keyboard.press("g")
    told.until("no ghost", lambda: len(ghost(told, "side")) == 0)
    assert not told.page.page.is_visible("[data-name=side] .explains")
    told.page.page.click("#ghost")
    told.until("the ghost again", lambda: len(ghost(told, "side")) > 50)
    told.age_ms = 400.0
    told.until("no ghost over an old picture", lambda: len(ghost(told, "side")) == 0)


@pytest.mark.slow
def test_nothing_is_drawn_by_a_calibration_that_is_for_pictures_of_another_shape(told: Told) -> None:
    told.until("the ghost", lambda: len(ghost(told, "side")) > 50)
    cell = scene.cell()
    wide = tuple(msgspec.structs.replace(camera, width=1280, height=720) for camera in cell.cameras)
    told.give(Hub.described, msgspec.structs.replace(cell, cameras=wide))
    told.until("no ghost", lambda: len(ghost(told, "side")) == 0)
    told.describe()
    told.until("the ghost again", lambda: len(ghost(told, "side")) > 50)


def test_one_sample_is_told_from_its_exposure_to_its_painted_picture(told: Told) -> None:
    told.state = partial(told.state, traced=told.traced(4711))
    told.until("the trace", lambda: "sample 4711" in told.page.words("#trace"))
    words = told.page.words("#trace")
    assert "command 21, robot 26, encoder 48, picture taken" in words
    assert float(words.rpartition("painted ")[2]) > 48
    grown = "(stages) => stages.map((stage) => Number(stage.style.flexGrow))"
    assert told.page.page.eval_on_selector_all("#trace-bar span", grown)[:3] == pytest.approx([21, 5, 22], abs=0.1)
    told.until("the figure", lambda: told.page.words("[data-interval=encoder] td:nth-of-type(2)") == "27")


def test_the_arm_is_looked_at_from_elsewhere_by_mouse_and_by_keys(told: Told) -> None:
    page = told.page.page
    told.until("the arm", lambda: "tool at" in told.page.words("#arm-words"))
    drawn = "() => document.getElementById('arm').toDataURL()"
    page.wait_for_timeout(100)
    seen = [page.evaluate(drawn)]
    page.focus("#arm")
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
        page.wait_for_timeout(100)
        seen.append(page.evaluate(drawn))
    box = page.locator("#arm").bounding_box()
    page.mouse.move(box["x"] + 50, box["y"] + 50)
    page.mouse.down()
    page.mouse.move(box["x"] + 120, box["y"] + 60)
    page.mouse.up()
    page.wait_for_timeout(100)
    assert len({*seen, page.evaluate(drawn)}) == 5


def test_the_button_holds_as_long_as_it_is_pressed(told: Told) -> None:
    told.until("the controls", lambda: "you operate" in told.page.words("#seat"))
    told.until("a key that is up", lambda: bool(told.intents) and not present(told.intents[-1].intent).hold)
    told.page.page.hover("#hold")
    told.page.page.mouse.down()
    told.until("holding", lambda: present(told.intents[-1].intent).hold)
    told.page.page.mouse.up()
    told.until("letting go", lambda: not present(told.intents[-1].intent).hold)


def test_a_click_enlarges_a_view_and_makes_it_small_again(told: Told) -> None:
    width = "() => document.querySelector('[data-name=side]').clientWidth"
    small = told.page.page.evaluate(width)
    told.page.page.click("[data-name=side]")
    assert told.page.page.evaluate(width) > 1.3 * small
    told.page.page.click("[data-name=side]")
    assert told.page.page.evaluate(width) == small


@pytest.mark.slow
@pytest.mark.parametrize(
    ("holder", "asked_by", "words"),
    [
        ("ben", None, "Ask ben for it"),
        ("ben", OPERATOR, "Ask again"),
        (OPERATOR, "ben", "Hand over to ben"),
    ],
)
def test_the_lease_says_whose_it_is_and_what_can_be_done(told: Told, holder: str, asked_by: str, words: str) -> None:
    asker = Asker(asked_by, ASKERS_SESSION) if asked_by is not None else None
    session = scene.hand().session if holder == OPERATOR else 9
    told.state = partial(told.state, lease=LeaseState(6, holder, session, time.monotonic_ns(), asker))
    told.until("the words", lambda: told.page.words("#lease-words") == words)
    assert told.page.page.is_visible("#lease-button")
    assert holder in told.page.words("#lease")
    asked = len(told.sites.consented)
    told.page.page.click("#lease-button")
    told.until("the request", lambda: len(told.sites.consented) > asked)
    assert told.sites.consented[-1] == (asker if holder == OPERATOR else None)


def test_another_host_of_the_own_name_is_asked_for_the_lease_like_anybody(told: Told) -> None:
    told.state = partial(told.state, lease=LeaseState(6, OPERATOR, 9, time.monotonic_ns(), None))
    told.until("the words", lambda: told.page.words("#lease-words") == f"Ask {OPERATOR} (site 9) for it")


@pytest.mark.parametrize(
    ("gripper", "next_command", "words"),
    [
        (GripperState(0.05, 12.0, CLOSED, GripperStatus.HOLDING), OPEN, "holding, 50 mm, 12 N; a toggle opens it"),
        (GripperState(0.03, None, KEEP, GripperStatus.UNKNOWN), CLOSED, "unknown, 30 mm; a toggle closes it"),
        (None, CLOSED, "not measured; a toggle closes it"),
    ],
)
def test_what_the_next_toggle_does_is_shown_before_it_happens(
    told: Told, gripper: GripperState | None, next_command: GripperCommand, words: str
) -> None:
    told.state = partial(told.state, gripper=gripper, gripper_next=next_command)
    told.until("the words", lambda: told.page.words("#gripper") == words)


@pytest.mark.slow
def test_the_age_that_the_page_tells_is_that_of_the_clock_in_its_picture(told: Told) -> None:
    page, image = told.page.page, np.full((*scene.SIZE, 3), 120, np.uint8)
    clock = compare(page)
    watch(page)

    def picture_of_now(camera: str, seq: int) -> VideoFrame:
        exposed_ns = time.monotonic_ns() - round(told.age_ms * NS_PER_MS)
        draw_clock(image, exposed_ns)
        return msgspec.structs.replace(scene.picture(camera, seq, encode_jpeg(image, 80)), capture_ns=exposed_ns)

    told.picture = picture_of_now
    told.until("the figures", lambda: bool(page.evaluate("window.paintedClocks.length > 40")))
    painted = ages_ms(page, clock)
    assert set(painted) == set(scene.CAMERAS)
    assert min(min(ages) for ages in painted.values()) >= told.age_ms - clock.uncertainty_ms - 2
    told_ms = float(told.page.words("[data-interval=picture] td:nth-of-type(2)"))
    read_ms = float(np.median(np.concatenate(list(painted.values()))))
    assert told_ms == pytest.approx(read_ms, abs=50.0 + 0.5 * read_ms)


KEEP_ALARMS = """() => {
  const line = document.getElementById("alert");
  window.alarms = [line.textContent];
  new MutationObserver(() => window.alarms.push(line.textContent)).observe(line, { childList: true, subtree: true });
}"""


@pytest.mark.slow
def test_a_stop_that_is_not_acknowledged_says_so_and_is_sent_until_it_is(told: Told) -> None:
    told.sites.silent = True
    told.page.page.keyboard.press("Escape")
    told.until("the alarm", lambda: "NOT ACKNOWLEDGED: nobody answers" in told.page.words("#alert"))
    told.page.page.evaluate(KEEP_ALARMS)
    told.page.page.keyboard.press("e")
    refused = told.sites.refused
    told.until("refusals of key and stop", lambda: told.sites.refused > refused + 3)
    assert all("repeated until it is acknowledged" in alarm for alarm in told.page.page.evaluate("window.alarms"))
    told.shot("stop not acknowledged")
    told.sites.silent = False
    told.until("the acknowledgement", lambda: "Stop acknowledged" in told.page.words("#alert"))


def test_the_joints_are_marked_by_clicks_or_keys_where_one_camera_sees_the_operator(told: Told) -> None:
    page, marked = told.page.page, told.sites.marked
    assert not page.is_visible("#joints-row")
    told.previews = ("left",)
    told.until("the offer", lambda: page.is_visible("#joints"))
    page.keyboard.press("j")
    box = page.locator("[data-name='operator left'] .picture").bounding_box()
    wide = min(box["width"], box["height"] * scene.SIZE[1] / scene.SIZE[0])
    middle = box["x"] + box["width"] / 2
    page.mouse.click(middle - 0.25 * wide, box["y"] + box["height"] / 2)
    page.mouse.click(middle - 0.6 * wide, box["y"] + box["height"] / 2)  # beside the picture
    assert "elbow" in told.page.words("#joints-words")
    told.shot("joints half marked")
    page.keyboard.press("Enter")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Shift+ArrowDown")
    page.keyboard.press("Enter")
    told.until("the marks", lambda: bool(marked))
    assert np.allclose(marked[-1], [(0.25, 0.5), (0.5, 0.5), (0.51, 0.502)], atol=0.01)
    assert page.get_attribute("#joints", "aria-pressed") == "false"
    assert page.evaluate(CHECK)["poor"] == []
    page.evaluate("() => document.querySelector('#cameras .enlarged')?.click()")  # the click beside was on a view


@pytest.mark.slow
def test_a_cell_without_a_held_key_shows_none_and_says_that_a_closed_page_holds_the_arm(told: Told) -> None:
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    assert told.page.page.is_visible("#hold")
    assert not told.page.page.is_visible("#unheld")
    told.describe(held=False)
    told.until(
        "the words", lambda: "If you close or hide this page, the arm stops" in told.page.page.inner_text("#controls")
    )
    told.until("no key", lambda: not told.page.page.is_visible("#hold"))
    told.shot("nothing held")
    assert told.page.page.evaluate(CHECK)["poor"] == []
    told.describe()
    told.until("the key", lambda: told.page.page.is_visible("#hold"))


@pytest.mark.slow
def test_a_view_of_the_operator_that_is_missing_keeps_no_old_picture(told: Told) -> None:
    """As when the local site ends and a recorded or taught path is run in its place."""
    picture = "#previews .picture"
    told.previews = ("left",)
    told.until("a picture", lambda: "live" in told.page.words("#previews"))
    assert told.page.page.is_visible(picture)
    why = "no camera is used: a taught path is run, place"
    told.troubles = dict.fromkeys(told.previews, (CameraStatus.MISSING, why))
    told.until("the reason", lambda: told.page.words("#previews").startswith(f"no picture{why}"))
    assert not told.page.page.is_visible(picture)
    told.shot("no_camera")
    told.troubles = {}
    told.until("a picture again", lambda: told.page.words("#previews").startswith("live"))


@pytest.mark.slow
def test_a_view_whose_pictures_are_late_now_and_then_does_not_flicker(told: Told) -> None:
    """Every second picture is old, as over a link that pauses; one that stays for long grows old by itself."""
    told.until("live views", lambda: set(told.page.marks()) == {"live"})
    began_s = time.monotonic()
    told.picture = lambda name, seq: scene.picture(name, seq, told.jpeg, age_ms=20.0 if seq % 2 else 400.0)
    told.until("the mark", lambda: told.mark("side") == "old")
    told.page.page.evaluate(COUNT_MARKS)
    told.until("a second", lambda: time.monotonic() - began_s > 3.0)
    assert told.page.page.evaluate("window.marksChanged") == 0
    told.reset()
    told.until("a live view", lambda: told.mark("side") == "live")


@pytest.mark.slow
def test_a_browser_that_decodes_no_jpeg_from_memory_paints_it_too(browser: object) -> None:
    with BareConsole() as console:
        page = OpenedPage(browser, "about:blank")
        page.context.add_init_script("delete window.ImageDecoder")
        page.page.goto(console.address)
        told = Told(console, page)
        told.describe()
        told.until("live views", lambda: set(page.marks()) == {"live"})
        page.close()


@pytest.mark.slow
def test_a_key_whose_beats_all_come_too_late_holds_nothing_and_the_page_says_so(told: Told) -> None:
    told.until("the controls", lambda: "you operate" in told.page.words("#seat"))
    page = told.page.page
    page.evaluate(SEND_LATE, 600)
    try:
        told.until("the word", lambda: "hear each other too late" in told.page.words("#seat"))
        before = len(told.intents)
        page.keyboard.down("Space")
        for _ in range(20):
            told.tell()
            page.wait_for_timeout(60)
    finally:
        page.keyboard.up("Space")
        page.evaluate(SEND_LATE, 0)
    reported = [sent.intent for sent in told.intents[before:]]
    assert not any(intent is not None and intent.hold for intent in reported)
