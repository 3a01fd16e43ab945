"""A cell with as many cameras as a test wants, and what of the page's room their pictures fill."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from msgspec.structs import replace

from common.messages.requests import CameraDescription
from common.messages.video import VideoFrame
from lab.measure.page import scene
from local_site.console.hub import Hub
from remote_site.video.streaming.pictures import encode_jpeg
from tests.browser.told import Told

COLOUR = (255, 0, 255)  # of no part of the page
FULL, WIDE = (480, 640), (360, 640)
BARE = ".view > span, .view .mark, #alert { visibility: hidden } .view::after { display: none }"
WEAR = """(rules) => {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(rules);
  document.adoptedStyleSheets = [sheet];
}"""
BOXES = """(selector) => [...document.querySelectorAll(selector)].filter((e) => e.checkVisibility()).map((e) => {
  const { left, top, width, height } = e.getBoundingClientRect();
  return [left, top, width, height];
})"""

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Room:
    """What is on the page, px: the views, the room for them, and how much of that is picture (0 to 1)."""

    views: Sequence[Box]
    room_px: float
    filled: float


def show_views(told: Told, shapes: Sequence[tuple[int, int]]) -> None:
    """Have the cell show pictures of these shapes (height, width), and wait until all are painted."""
    names = tuple(f"view_{k}" for k in range(len(shapes)))
    jpegs = [encode_jpeg(np.full((*shape, 3), COLOUR, np.uint8), 90) for shape in shapes]
    cameras = tuple(CameraDescription(name, 640, 480, 30.0) for name in names)  # as configured, whatever they give
    told.give(Hub.described, replace(scene.cell(), cameras=cameras))
    told.cameras = names

    def picture(camera: str, seq: int) -> VideoFrame:
        return scene.picture(camera, seq, jpegs[names.index(camera)])

    told.picture = picture
    told.until("the views", lambda: len(told.page.marks()) == len(names) and "none" not in told.page.marks())
    shaped = [round(width / height, 1) for height, width in shapes]
    told.until("their shapes", lambda: [round(w / h, 1) for _, _, w, h in boxes(told, "#cameras .view")] == shaped)


def boxes(told: Told, selector: str) -> list[Box]:
    """Left, top, width and height of what is shown, px."""
    return [tuple(box) for box in told.page.page.evaluate(BOXES, selector)]


def painted(told: Told) -> Room:
    """Look at the page's pixels: what is neither side nor strip has to be picture."""
    page: Any = told.page.page
    page.evaluate(WEAR, BARE)
    told.tell()
    page.wait_for_timeout(100)
    shot = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_COLOR)
    assert shot is not None
    seen = shot.astype(int)
    page.evaluate(WEAR, "")
    is_room = np.zeros(seen.shape[:2], bool)
    _mark(is_room, boxes(told, "#room")[0], value=True)
    for box in boxes(told, "#side, #strip[data-placed], #no-views"):
        _mark(is_room, box, value=False)
    is_picture = np.abs(seen - COLOUR).max(axis=2) < 60
    return Room(boxes(told, "#cameras .view"), float(is_room.sum()), float(is_picture[is_room].mean()))


def _mark(pixels: np.ndarray, box: Box, *, value: bool) -> None:
    left, top, width, height = box
    pixels[max(0, round(top)) : max(0, round(top + height)), max(0, round(left)) : max(0, round(left + width))] = value
