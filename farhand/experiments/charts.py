"""Line charts as pictures: panels with axes, units and legend, side by side under one title."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array

Colour = tuple[int, int, int]

BLACK, GREY, PALE = (30, 30, 30), (110, 110, 110), (225, 225, 225)
FONT = cv2.FONT_HERSHEY_SIMPLEX
WIDTH, HEIGHT = 800, 330
LEFT, RIGHT, TOP, BOTTOM = 78, 18, 40, 54
HEAD = 48
SMALL, MIDDLE = 0.45, 0.52
TICKS = 8
SUBPIXEL_BITS = 4


@dataclass(frozen=True, slots=True)
class Line:
    """One curve: its name in the legend, its colour (blue, green, red) and thickness in px, and its values (N,)."""

    name: str
    colour: Colour
    thickness: int
    x: Array
    y: Array


@dataclass(frozen=True, slots=True)
class Panel:
    """One chart: title, what the axes show with their units, the curves, and the range (low, high) of each axis."""

    title: str
    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    x_range: tuple[float, float]
    y_range: tuple[float, float]


def common_range(values: Sequence[Array], least: float) -> tuple[float, float]:
    """A range that holds all numbers with a margin, at least so wide, so that charts of one row can be compared."""
    every = np.concatenate([v[np.isfinite(v)] for v in values])
    low, high = float(every.min()), float(every.max())
    margin = max(0.08 * (high - low), 0.5 * (least - (high - low)))
    return low - margin, high + margin


def figure(title: str, rows: Sequence[Sequence[Panel]]) -> Image:
    """All panels in rows under a title and one legend, that of the first, as a picture (H, W, 3)."""
    body = np.vstack([np.hstack([_drawn(panel) for panel in row]) for row in rows])
    head = np.full((HEAD, body.shape[1], 3), 255, np.uint8)
    _write(head, title, (LEFT, 32), 0.7, BLACK, 2)
    _draw_legend(head, rows[0][0].lines)
    return np.vstack([head, body])


def _drawn(panel: Panel) -> Image:
    picture = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    _write(picture, panel.title, (LEFT, 26), MIDDLE, BLACK)
    for value in _ticks(panel.x_range):
        x = _across(panel, value)
        cv2.line(picture, (x, TOP), (x, HEIGHT - BOTTOM), PALE, 1)
        _write(picture, f"{value:g}", (x - _width(f"{value:g}") // 2, HEIGHT - BOTTOM + 18), SMALL, GREY)
    for value in _ticks(panel.y_range):
        y = _down(panel, value)
        cv2.line(picture, (LEFT, y), (WIDTH - RIGHT, y), PALE, 1)
        _write(picture, f"{value:g}", (LEFT - 8 - _width(f"{value:g}"), y + 5), SMALL, GREY)
    cv2.rectangle(picture, (LEFT, TOP), (WIDTH - RIGHT, HEIGHT - BOTTOM), GREY, 1)
    for line in panel.lines:
        _draw_line(picture, panel, line)
    _write(
        picture,
        panel.x_label,
        ((WIDTH + LEFT - RIGHT - _width(panel.x_label, MIDDLE)) // 2, HEIGHT - 12),
        MIDDLE,
        BLACK,
    )
    picture[:, :22] = _upright(panel.y_label)
    return picture


def _draw_line(picture: Image, panel: Panel, line: Line) -> None:
    """The curve, broken where it is not a number."""
    known = np.isfinite(line.y)
    for piece in np.split(np.arange(len(line.y)), np.flatnonzero(~known)):
        piece = piece[known[piece]]  # noqa: PLW2901  # the first of a piece may be the gap itself
        if len(piece) < 2:
            continue
        x = LEFT + (line.x[piece] - panel.x_range[0]) * _per_x(panel)
        y = HEIGHT - BOTTOM - (line.y[piece] - panel.y_range[0]) * _per_y(panel)
        points = np.round(np.column_stack([x, y]) * 2**SUBPIXEL_BITS).astype(np.int32)
        cv2.polylines(picture, [points], False, line.colour, line.thickness, cv2.LINE_AA, SUBPIXEL_BITS)


def _draw_legend(head: Image, lines: Sequence[Line]) -> None:
    """Names beside their colours, in a row at the right end."""
    x = head.shape[1] - RIGHT - sum(_legend_width(line) for line in lines)
    for line in lines:
        cv2.line(head, (x, 27), (x + 30, 27), line.colour, line.thickness, cv2.LINE_AA)
        _write(head, line.name, (x + 38, 32), MIDDLE, BLACK)
        x += _legend_width(line)


def _legend_width(line: Line) -> int:
    return 66 + _width(line.name, MIDDLE)


def _upright(text: str) -> Image:
    """A strip (HEIGHT, 22, 3) with text that reads upwards."""
    strip = np.full((22, HEIGHT, 3), 255, np.uint8)
    _write(strip, text, ((HEIGHT + BOTTOM - TOP - _width(text, MIDDLE)) // 2, 16), MIDDLE, BLACK)
    return np.rot90(strip)


def _write(picture: Image, text: str, place: tuple[int, int], size: float, colour: Colour, weight: int = 1) -> None:
    cv2.putText(picture, text, place, FONT, size, colour, weight, cv2.LINE_AA)


def _width(text: str, size: float = SMALL) -> int:
    return int(cv2.getTextSize(text, FONT, size, 1)[0][0])


def _ticks(between: tuple[float, float]) -> Array:
    """Round values inside a range, about TICKS of them."""
    low, high = between
    rough = (high - low) / TICKS
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * round_one for round_one in (1.0, 2.0, 5.0, 10.0) if power * round_one >= rough)
    return np.round(np.arange(math.ceil(low / step), math.floor(high / step) + 1) * step, 9) + 0.0


def _per_x(panel: Panel) -> float:
    return (WIDTH - LEFT - RIGHT) / (panel.x_range[1] - panel.x_range[0])


def _per_y(panel: Panel) -> float:
    return (HEIGHT - TOP - BOTTOM) / (panel.y_range[1] - panel.y_range[0])


def _across(panel: Panel, x: float) -> int:
    return round(LEFT + (x - panel.x_range[0]) * _per_x(panel))


def _down(panel: Panel, y: float) -> int:
    return round(HEIGHT - BOTTOM - (y - panel.y_range[0]) * _per_y(panel))
