"""Printed matter and tools: posters, labels, binders, a rule, a pegboard; and the shadows of what lies on a surface."""

import itertools

import cv2
import numpy as np

from remote_site.simulation.appearance.materials import Colour, Field, Picture, noise, plain, rgb, tinted

INK: Colour = (0.16, 0.17, 0.19)
PAPER: Colour = (0.90, 0.90, 0.87)
STEEL: Colour = (0.60, 0.62, 0.64)
FONT = cv2.FONT_HERSHEY_SIMPLEX
FINE = 3  # text is drawn this many times larger, then made smaller: OpenCV's letters have no shape at 8 pixels
SHADOW = 0.45
HANGS_M, MARGIN_PX = 0.34, 16


def paste(ground: Picture, sheet: Picture, top: int, left: int, lift_px: int = 2) -> None:
    """Lay a picture on the ground, with the soft shadow of something that stands off by about `lift_px`."""
    height, width = sheet.shape[:2]
    mask = np.zeros(ground.shape[:2], dtype=np.float32)
    mask[top : top + height, left : left + width] = 1.0
    _cast(ground, mask, lift_px)
    room = ground[top : top + height, left : left + width]
    room[:] = sheet[: room.shape[0], : room.shape[1]]


def text(picture: Picture, words: str, at: tuple[int, int], height_px: float, colour: Colour = INK) -> None:
    """Print one line, its lower left corner at (row, column)."""
    scale = FINE * height_px / 21.0
    (width, height), below = cv2.getTextSize(words, FONT, scale, FINE)
    stamp = np.zeros((height + below + FINE, width + FINE), dtype=np.uint8)
    cv2.putText(stamp, words, (0, height), FONT, scale, 255, max(1, round(scale * 1.6)), cv2.LINE_AA)
    small = cv2.resize(stamp, None, fx=1 / FINE, fy=1 / FINE, interpolation=cv2.INTER_AREA)
    top, left = max(0, at[0] - round(height / FINE)), at[1]
    room = picture[top : top + small.shape[0], left : left + small.shape[1]]
    ink = small[: room.shape[0], : room.shape[1], None] / np.float32(255.0)
    room += ink * (rgb(colour) - room)


def paragraph(rng: np.random.Generator, picture: Picture, line_px: int = 4) -> None:
    """Fill a picture with lines of words too small to be read."""
    height, width = picture.shape[:2]
    for top in range(line_px, height - line_px, line_px):
        end = width * (rng.uniform(0.4, 0.8) if rng.random() < 0.15 else rng.uniform(0.9, 1.0))
        ink = np.repeat(rng.random(width // 2 + 1) > 0.16, 2)[:width] & (np.arange(width) < end)
        tone = np.float32(0.35) + np.float32(0.25) * rng.random((width, 1), dtype=np.float32)
        thick = max(1, line_px // 2)
        picture[top : top + thick, ink] *= tone[ink]


def poster(rng: np.random.Generator, shape: tuple[int, int], title: str, colour: Colour) -> Picture:
    """A conference poster: title, text in two columns, a drawing of an arm, a chart."""
    height, width = shape
    sheet = plain(shape, PAPER)
    head = round(0.15 * height)
    sheet[:head] = colour
    text(sheet, title, (round(0.7 * head), round(0.06 * width)), 0.34 * head, PAPER)
    text(sheet, "Department of Telerobotics", (round(0.92 * head), round(0.06 * width)), 0.15 * head, PAPER)
    left, middle, right = round(0.06 * width), round(0.52 * width), round(0.94 * width)
    half = round(0.56 * height)
    paragraph(rng, sheet[head + 6 : half, left : middle - 5])
    paragraph(rng, sheet[half + 4 : height - 8, middle:right])
    _drawn_arm(sheet[head + 8 : half, middle:right], colour)
    _chart(rng, sheet[half + 8 : height - 8, left : middle - 5], colour)
    return sheet


def notice(rng: np.random.Generator, shape: tuple[int, int], title: str) -> Picture:
    """A sheet of paper with a heading and small print."""
    sheet = plain(shape, PAPER)
    height, width = shape
    text(sheet, title, (round(0.16 * height), round(0.10 * width)), 0.075 * height)
    paragraph(rng, sheet[round(0.24 * height) : round(0.92 * height), round(0.1 * width) : round(0.9 * width)])
    return sheet


def label(rng: np.random.Generator, shape: tuple[int, int], words: str) -> Picture:
    """A shipping label: a line of text, small print, a bar code."""
    sheet = plain(shape, (0.88, 0.88, 0.86))
    height, width = shape
    text(sheet, words, (round(0.34 * height), 3), 0.22 * height)
    paragraph(rng, sheet[round(0.4 * height) : round(0.7 * height), 3:-3], 3)
    bars = np.flatnonzero(rng.random(width - 8) > 0.5) + 4
    sheet[round(0.72 * height) : -2, bars] = INK
    return sheet


def binders(rng: np.random.Generator, shape: tuple[int, int]) -> Picture:
    """The backs of a row of binders, each with a label and a finger hole."""
    height, width = shape
    row = plain(shape, (0.12, 0.12, 0.13))
    left = 0
    while left < width - 8:
        wide = int(rng.integers(round(0.16 * height), round(0.27 * height)))
        tone = rng.choice([0.20, 0.28, 0.46, 0.62])
        colour = (tone, tone * rng.uniform(0.98, 1.06), tone * rng.uniform(0.9, 1.02))
        back = row[round(rng.uniform(0.0, 0.08) * height) :, left : left + wide - 1]
        back[:] = colour
        back[:, :2] *= 0.8
        inset = max(2, wide // 6)
        sheet = back[round(0.12 * height) : round(0.50 * height), inset:-inset]
        sheet[:] = PAPER
        paragraph(rng, sheet[2:-2, 1:-1], 5)
        middle = (round(back.shape[1] / 2), round(0.78 * back.shape[0]))
        spot = np.ascontiguousarray(back)
        cv2.circle(spot, middle, max(2, wide // 6), (0.55, 0.56, 0.57), -1, cv2.LINE_AA)
        cv2.circle(spot, middle, max(1, wide // 9), (0.06, 0.06, 0.06), -1, cv2.LINE_AA)
        back[:] = spot
        left += wide
    return row


def steel_rule(shape: tuple[int, int]) -> Picture:
    """A steel rule of 30 cm with its divisions."""
    height, width = shape
    rule = plain(shape, (0.66, 0.67, 0.67))
    for mm in range(5, 300, 2):
        column = round(mm / 300 * width)
        long = 0.55 if mm % 50 in (0, 1) else 0.42 if mm % 10 in (0, 1) else 0.25
        rule[: round(long * height), column] = INK
    for cm in range(5, 30, 5):
        text(rule, str(cm), (height - 2, round(cm / 30 * width) - 5), 0.35 * height)
    return rule


def pegboard(rng: np.random.Generator, shape: tuple[int, int], px_m: float) -> Picture:
    """A perforated board on which tools and coiled cables hang."""
    height, width = shape
    board = tinted(np.float32(1.0) + np.float32(0.025) * noise(rng, shape, (3.0, 9.0)), (0.66, 0.63, 0.58))
    pitch = 0.025 * px_m
    for row in np.arange(pitch, height - 2, pitch):
        for column in np.arange(pitch, width - 2, pitch):
            board[round(row) - 1 : round(row) + 1, round(column) - 1 : round(column) + 1] *= 0.35
    along = 0.06
    while along < width / px_m - 0.12:
        kind = int(rng.integers(0, 5))
        top = float(rng.uniform(0.05, 0.12)) if rng.random() < 0.55 else float(rng.uniform(0.36, 0.44))
        along += _hang(rng, board, kind, (top * px_m, along * px_m), px_m)
    return board


def cable(picture: Picture, path: list[tuple[float, float]], width_px: float, colour: Colour) -> None:
    """A cable along smooth curves through the points (row, column), with its shadow and its sheen."""
    points = np.array(path, dtype=float)
    steps = np.linspace(0, len(points) - 1, 60 * len(points))
    smooth = np.stack([np.interp(steps, np.arange(len(points)), points[:, k]) for k in (1, 0)], axis=1)
    smooth = cv2.GaussianBlur(smooth, (1, 121), 0, borderType=cv2.BORDER_REPLICATE)
    thick = max(1, round(width_px))
    margin = 4 * thick + 8
    low = np.maximum(np.floor(smooth.min(axis=0)).astype(int) - margin, 0)
    high = np.maximum(np.ceil(smooth.max(axis=0)).astype(int) + margin, low + 1)
    area = picture[low[1] : high[1], low[0] : high[0]]
    line = np.rint((smooth - low) * 16).astype(np.int32)[:, None, :]
    mask, sheen = np.zeros(area.shape[:2], dtype=np.float32), np.zeros(area.shape[:2], dtype=np.float32)
    cv2.polylines(mask, [line], False, 1.0, thick, cv2.LINE_AA, 4)
    cv2.polylines(
        sheen,
        [line + np.array((8, -8), dtype=np.int32)],
        False,
        0.35 if thick > 2 else 0.0,
        max(1, thick // 3),
        cv2.LINE_AA,
        4,
    )
    _cast(area, mask, max(1, thick // 2))
    area += mask[:, :, None] * (rgb(colour) - area)
    area += sheen[:, :, None] * (np.float32(0.75) - area)


def _cast(ground: Picture, mask: Field, lift_px: int) -> None:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    margin = 4 * lift_px + 4
    window = (
        slice(max(0, rows[0] - margin), rows[-1] + margin),
        slice(max(0, columns[0] - margin), columns[-1] + margin),
    )
    moved = np.roll(mask[window], (lift_px, -lift_px), (0, 1))
    shadow = cv2.GaussianBlur(moved, (0, 0), 0.6 + 0.7 * lift_px)
    ground[window] *= np.asarray(1.0 - SHADOW * shadow, dtype=np.float32)[:, :, None]


def _drawn_arm(area: Picture, colour: Colour) -> None:
    sheet = np.ascontiguousarray(area)
    height, width = sheet.shape[:2]
    joints = ((0.3, 0.95), (0.3, 0.6), (0.5, 0.3), (0.8, 0.42), (0.88, 0.6))
    points = [(round(x * width), round(y * height)) for x, y in joints]
    for start, end in itertools.pairwise(points):
        cv2.line(sheet, start, end, colour, 5, cv2.LINE_AA)
    for point in points[:-1]:
        cv2.circle(sheet, point, 5, INK, -1, cv2.LINE_AA)
    cv2.rectangle(sheet, (2, 2), (width - 3, height - 3), (0.6, 0.6, 0.6), 1)
    area[:] = sheet


def _chart(rng: np.random.Generator, area: Picture, colour: Colour) -> None:
    sheet = np.ascontiguousarray(area)
    height, width = sheet.shape[:2]
    for tone in (colour, INK):
        level = np.clip(0.6 + 0.1 * np.cumsum(rng.standard_normal(20)), 0.1, 0.9)
        line = np.stack([np.linspace(4, width - 4, 20), level * (height - 4)], axis=1)
        cv2.polylines(sheet, [np.rint(line).astype(np.int32)], False, tone, 1, cv2.LINE_AA)
    cv2.line(sheet, (3, 2), (3, height - 3), INK, 1)
    cv2.line(sheet, (3, height - 3), (width - 3, height - 3), INK, 1)
    area[:] = sheet


def _hang(rng: np.random.Generator, board: Picture, kind: int, at: tuple[float, float], px_m: float) -> float:
    """Draw one tool hanging at (row, column) and return the width (m) that it takes."""
    reach = round(HANGS_M * px_m)
    top, left = MARGIN_PX, MARGIN_PX
    rows, columns = (slice(max(0, round(start) - MARGIN_PX), round(start) + reach) for start in at)
    area = board[rows, columns]
    layer, mask = np.zeros_like(area), np.zeros(area.shape[:2], dtype=np.float32)

    def line(rows: tuple[float, float], column: float, width_m: float, colour: Colour) -> None:
        ends = [(round(left + column * px_m), round(top + row * px_m)) for row in rows]
        for target, tone in ((layer, colour), (mask, (1.0,))):
            cv2.line(target, ends[0], ends[1], tone, max(1, round(width_m * px_m)), cv2.LINE_AA)

    def ring(row: float, column: float, radius_m: float, width_m: float, colour: Colour) -> None:
        centre = (round(left + column * px_m), round(top + row * px_m))
        thick = -1 if width_m == 0 else max(1, round(width_m * px_m))
        for target, tone in ((layer, colour), (mask, (1.0,))):
            cv2.circle(target, centre, round(radius_m * px_m), tone, thick, cv2.LINE_AA)

    if kind == 0:  # screwdriver
        handle: Colour = ((0.14, 0.15, 0.16), (0.22, 0.34, 0.24), (0.34, 0.20, 0.18))[int(rng.integers(3))]
        line((0.0, 0.09), 0.02, 0.026, handle)
        line((0.10, 0.20), 0.02, 0.007, STEEL)
        taken = 0.065
    elif kind == 1:  # spanner
        line((0.02, 0.17), 0.025, 0.014, STEEL)
        ring(0.01, 0.025, 0.017, 0.009, STEEL)
        ring(0.18, 0.025, 0.019, 0.010, STEEL)
        taken = 0.075
    elif kind == 2:  # hammer
        line((0.03, 0.26), 0.05, 0.022, (0.48, 0.37, 0.26))
        line((0.015, 0.030), 0.05, 0.10, (0.25, 0.26, 0.28))
        taken = 0.15
    elif kind == 3:  # coiled cable
        for radius in (0.075, 0.085, 0.066):
            ring(
                0.10 + rng.uniform(-0.006, 0.006), 0.095 + rng.uniform(-0.006, 0.006), radius, 0.008, (0.11, 0.11, 0.12)
            )
        taken = 0.21
    else:  # roll of tape
        ring(0.05, 0.06, 0.044, 0.030, (0.50, 0.50, 0.47))
        taken = 0.13
    _cast(area, mask, 3)
    area += mask[:, :, None] * (layer - area)
    return taken
