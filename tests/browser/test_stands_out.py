"""What is seen in every state: STOP, which never lies on the bar's own colour, and what the arm does, as a shape."""

from functools import partial

import cv2
import numpy as np
import pytest

from common.geometry import Array
from common.messages.robot import SessionState
from lab.measure.page import scene
from lab.measure.page.screenshots import STATES
from tests.browser.told import Told
from tests.present import present

TONES = {"engaged": "engaged", "limited": "holding", "ready": "idle", "stopped": "fault", "another operates": "other"}
BESIDE_PX = 3  # from the button's edge
SHAPE = """() => {
  const { content, clipPath } = getComputedStyle(document.getElementById("state-word"), "::before");
  return [document.getElementById("state").dataset.state, content, clipPath];
}"""


def luminance(colour: Array) -> float:
    """The relative luminance of a colour of a picture, as WCAG defines it."""
    bgr = np.asarray(colour, float) / 255.0
    linear = np.where(bgr <= 0.04045, bgr / 12.92, ((bgr + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.0722, 0.7152, 0.2126))


def contrast(a: Array, b: Array) -> float:
    light, dark = sorted((luminance(a), luminance(b)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", TONES)
def test_stop_stands_out_from_what_is_around_it(told: Told, name: str) -> None:
    told.state = STATES[name]
    told.until("the colour", lambda: told.page.page.get_attribute("body", "data-tone") == TONES[name])
    box = told.page.page.locator("#stop").bounding_box()
    shot = present(cv2.imdecode(np.frombuffer(told.page.page.screenshot(), np.uint8), cv2.IMREAD_COLOR))
    row = round(box["y"] + box["height"] / 2)
    ground, around = shot[row, round(box["x"]) + 8], shot[row, round(box["x"]) - BESIDE_PX]
    assert contrast(ground, around) >= 3.0


@pytest.mark.slow
def test_each_thing_that_the_arm_does_has_a_shape_besides_its_colour(told: Told) -> None:
    shapes: dict[str, str] = {}

    def has_shape(name: str) -> bool:
        state, content, shapes[name] = told.page.page.evaluate(SHAPE)
        return bool(state == name and content != "none")

    states = {name: STATES[name] for name in ("engaged", "limited", "holding", "stopped", "fault")}
    states["clutched"] = partial(scene.state, SessionState.HOLDING, "clutched", "the clutch is held")
    for name, state in states.items():
        told.state = state
        told.until("its shape", partial(has_shape, name))
    assert shapes.pop("clutched") == shapes["holding"]  # in both the arm waits
    assert len(set(shapes.values())) == len(shapes)
