"""Views side by side above a band that says time, state, task and joints; pure."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import cv2
import numpy as np

from farhand.export.videos.h264 import Rgb

LINE_PX, MARGIN_PX, NAME_PX = 20, 6, 18
FONT, SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.45
DARK, LIGHT = (24, 24, 28), (235, 235, 235)


class MosaicPlan(NamedTuple):
    """The places of the views: each in a cell (width, height), so many side by side, above `lines` of text."""

    views: tuple[str, ...]
    cell_px: tuple[int, int]
    lines: int

    @property
    def across(self) -> int:
        """The number of cells side by side."""
        return max(int(np.ceil(np.sqrt(len(self.views)))), 1)

    @property
    def size_px(self) -> tuple[int, int]:
        """The whole picture (width, height), both even."""
        width, height = self.cell_px
        down = -(-len(self.views) // self.across)
        total = self.across * width, down * height + self.lines * LINE_PX + 2 * MARGIN_PX
        return total[0] + total[0] % 2, total[1] + total[1] % 2


def mosaic(plan: MosaicPlan, pictures: Mapping[str, Rgb], lines: Sequence[str]) -> Rgb:
    """The picture (height, width, 3): a view without one stays dark, and says so."""
    width, height = plan.size_px
    canvas: Rgb = np.full((height, width, 3), DARK, np.uint8)
    across, (cell_width, cell_height) = plan.across, plan.cell_px
    for k, view in enumerate(plan.views):
        y, x = k // across * cell_height, k % across * cell_width
        picture = pictures.get(view)
        if picture is not None:
            canvas[y : y + cell_height, x : x + cell_width] = fitted(picture, plan.cell_px)
        _write(canvas, view if picture is not None else f"{view}: no picture yet", x + MARGIN_PX, y + NAME_PX)
    top = height - plan.lines * LINE_PX - MARGIN_PX
    for k, line in enumerate(lines[: plan.lines]):
        _write(canvas, line, MARGIN_PX, top + (k + 1) * LINE_PX - MARGIN_PX)
    return canvas


def fitted(picture: Rgb, cell_px: tuple[int, int]) -> Rgb:
    """The picture in the size (width, height) of a cell."""
    if picture.shape[1::-1] == cell_px:
        return picture
    resized: Rgb = cv2.resize(picture, cell_px, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
    return resized


def _write(canvas: Rgb, text: str, x: int, y: int) -> None:
    """Light letters with a dark border, readable on any picture."""
    for colour, thickness in ((DARK, 3), (LIGHT, 1)):
        cv2.putText(canvas, text, (x, y), FONT, SCALE, colour, thickness, cv2.LINE_AA)
