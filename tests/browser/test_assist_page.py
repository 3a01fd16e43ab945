"""The assist on the page: what it offers in words and over the pictures, and the key that asks for just that."""

from functools import partial

import numpy as np

from common.geometry import transform
from common.messages.robot import AssistPhase, AssistState, AssistTarget, Pose
from lab.measure.page import scene
from tests.browser.told import Told

CHECK = "() => document.querySelector('#assist-row').hidden"
OFFER = "hold A: the tool will move 12 mm and 3 deg to grasp 'block'"
COVERED = "marker 3 is covered, or out of all calibrated views"
MARKER = transform(np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]), np.array([0.596, 0.0, 0.70]))  # towards the cameras
VIEWS = ("front_high", "front_low")
DRAWN = """(name) => {
  const canvas = document.querySelector(`[data-name=${name}] .assist`);
  const { width, height } = canvas;
  const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
  const points = [];
  for (let k = 0; k < data.length; k += 4) {
    const [red, green, , opaque] = data.slice(k, k + 4);
    if (opaque > 200 && green > 200 && red < 180) points.push([(k / 4) % width, Math.floor(k / 4 / width)]);
  }
  return { width, height, points };
}"""


def assist(phase: AssistPhase, reason: str, *, aims: bool = True) -> AssistState:
    """What the remote site reports of it."""
    target = AssistTarget(
        name="block",
        kind="grasp",
        base_T_marker=Pose.from_transform(MARKER),
        size=0.04,
        base_T_tool=Pose.from_transform(MARKER),
        distance_mm=12.0,
        angle_deg=3.0,
        views=VIEWS,
    )
    return AssistState(phase=phase, code=f"assist_{phase.value}", reason=reason, target=target if aims else None)


def tell(told: Told, state: AssistState | None) -> None:
    told.state = partial(told.state, assist=state)


def drawn(told: Told, camera: str) -> np.ndarray:
    """Where it is drawn in green, in pixels of the full picture."""
    found = told.page.page.evaluate(DRAWN, camera)
    height, width = scene.SIZE
    scale = min(found["width"] / width, found["height"] / height)
    margin = (np.array([found["width"], found["height"]]) - scale * np.array([width, height])) / 2
    return np.asarray((np.array(found["points"]).reshape(-1, 2) + 0.5 - margin) / scale)


def outline(told: Told, camera: str) -> np.ndarray:
    """Where it is drawn, once it is; while a machine is busy a picture may be too old for it for a moment."""
    found: list[np.ndarray] = []
    told.until(f"the outline in {camera}", lambda: found.append(drawn(told, camera)) or len(found[-1]) > 50)
    return found[-1]


def ask(told: Told) -> None:
    """Press the key until it asks: a page that has just not been told for too long offers nothing to ask for."""

    def is_asked() -> bool:
        if asked(told) == "block":
            return True
        told.page.page.keyboard.up("a")
        told.page.page.keyboard.down("a")
        return False

    told.until("the request", is_asked)


def asked(told: Told) -> str | None:
    """What the newest intent asks for."""
    newest = told.intents[-1].intent
    return newest.assist if newest is not None else None


def test_without_targets_the_page_shows_nothing_of_it(told: Told) -> None:
    told.until("no row", lambda: told.page.page.evaluate(CHECK) is True)


def test_the_offer_is_said_and_drawn_where_the_views_see_it_before_the_key_asks_for_it(told: Told) -> None:
    tell(told, assist(AssistPhase.OFFERED, OFFER))
    told.until("the offer", lambda: told.page.words("#assist-words") == OFFER)
    told.age_ms = -60_000.0  # young enough for an outline, however slow the machine
    for camera in scene.cell().cameras:
        if camera.name not in VIEWS or camera.calibration is None:
            continue
        corner = MARKER @ (-0.02, 0.02, 0, 1)
        u, v, w = np.reshape(camera.calibration.projection, (3, 4)) @ corner
        assert np.linalg.norm(outline(told, camera.name) - (u / w, v / w), axis=1).min() < 3.0, camera.name
    assert len(drawn(told, "side")) == 0
    told.shot("assist")
    assert asked(told) is None
    ask(told)
    told.page.page.keyboard.up("a")
    told.until("the release", lambda: asked(told) is None)


def test_a_key_pressed_before_the_offer_asks_for_nothing(told: Told) -> None:
    tell(told, assist(AssistPhase.OFF, COVERED, aims=False))
    told.until("the reason", lambda: told.page.words("#assist-words") == COVERED)
    told.page.page.keyboard.down("a")
    tell(told, assist(AssistPhase.OFFERED, OFFER))
    told.until("the offer", lambda: told.page.words("#assist-words") == OFFER)
    assert asked(told) is None
    told.page.page.keyboard.up("a")


def test_a_stop_lets_go_of_it(told: Told) -> None:
    tell(told, assist(AssistPhase.OFFERED, OFFER))
    told.until("the offer", lambda: told.page.words("#assist-words") == OFFER)
    ask(told)
    told.page.page.keyboard.press("Escape")
    told.until("the release", lambda: asked(told) is None)
    told.page.page.keyboard.up("a")
