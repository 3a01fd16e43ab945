"""The part of a picture that shows the arm: it follows calmly, and is the whole picture while no arm is tracked."""

import math
from dataclasses import dataclass

from common.clock import NS_PER_S

LEAST_SIDE = 1 / 3  # of the picture: a smaller part would be enlarged on the page until it is blurred
MARGIN = 0.08  # of the picture, between the arm and the edge of a part newly chosen
LEAST_MARGIN = 0.03  # the part stays while the arm keeps so far from its edge
LARGEST_EXCESS = 1.25  # and is no larger than so many times what would be chosen now
SETTLE_S = 0.5  # of loss before the whole picture is shown, and of tracking before a part is
LONGEST_STEP_S = 0.2  # what one picture counts at most, however long after the last it comes
FOLLOW_S = 0.2  # time constant of the motion
ROUNDING = 1e-9


@dataclass(frozen=True, slots=True)
class PictureBox:
    """A rectangle in a picture, in fractions of the picture's width and height from its upper left corner."""

    left: float
    top: float
    right: float
    bottom: float


WHOLE = PictureBox(0.0, 0.0, 1.0, 1.0)


class ArmWindow:
    """The part of one camera's picture to be shown, always of the whole picture's proportions and within it."""

    def __init__(self) -> None:
        self._shown = self._aim = WHOLE
        self._is_near = False
        self._evidence = 0.0
        self._t_ns: int | None = None

    def at(self, t_ns: int, arm: PictureBox | None) -> PictureBox:
        """The part at an instant, with the box of the arm in the picture, or None while none is tracked."""
        elapsed_s = 0.0 if self._t_ns is None else max(0.0, (t_ns - self._t_ns) / NS_PER_S)
        self._t_ns = t_ns
        self._judge(elapsed_s if arm is not None else -elapsed_s)
        if not self._is_near:
            self._aim = WHOLE
        elif arm is not None and not _suits(self._aim, arm):
            self._aim = _around(_grown(arm, MARGIN))
        self._shown = _between(self._shown, self._aim, 1.0 - math.exp(-elapsed_s / FOLLOW_S))
        if self._is_near and arm is not None:
            self._shown = _around(_union(self._shown, arm))  # an arm that is quicker than the part is not cut
        return self._shown

    def _judge(self, seen_s: float) -> None:
        """Count time with the arm seen, less than zero without; only at either end the decision changes."""
        step_s = min(max(seen_s, -LONGEST_STEP_S), LONGEST_STEP_S)
        self._evidence = min(max(self._evidence + step_s / SETTLE_S, 0.0), 1.0)
        if self._evidence in {0.0, 1.0}:
            self._is_near = self._evidence == 1.0


def _suits(part: PictureBox, arm: PictureBox) -> bool:
    """Return whether a part may stay: the arm is well inside, as far as the picture goes, and not small in it."""
    near, chosen = _grown(arm, LEAST_MARGIN), _around(_grown(arm, MARGIN))
    outside = max(part.left - near.left, part.top - near.top, near.right - part.right, near.bottom - part.bottom)
    return outside < ROUNDING and part.right - part.left <= LARGEST_EXCESS * (chosen.right - chosen.left)


def _grown(box: PictureBox, margin: float) -> PictureBox:
    """The box with a margin on each side that the picture has."""
    left, top = max(0.0, box.left - margin), max(0.0, box.top - margin)
    return PictureBox(left, top, min(1.0, box.right + margin), min(1.0, box.bottom + margin))


def _around(box: PictureBox) -> PictureBox:
    """The smallest permitted part with a box of the picture in its middle, or as near to that as the picture allows."""
    side = max(box.right - box.left, box.bottom - box.top, LEAST_SIDE)
    left = min(max((box.left + box.right - side) / 2, 0.0), 1.0 - side)
    top = min(max((box.top + box.bottom - side) / 2, 0.0), 1.0 - side)
    return PictureBox(left, top, left + side, top + side)


def _union(a: PictureBox, b: PictureBox) -> PictureBox:
    return PictureBox(min(a.left, b.left), min(a.top, b.top), max(a.right, b.right), max(a.bottom, b.bottom))


def _between(a: PictureBox, b: PictureBox, share: float) -> PictureBox:
    def mix(start: float, end: float) -> float:
        return start + share * (end - start)

    return PictureBox(mix(a.left, b.left), mix(a.top, b.top), mix(a.right, b.right), mix(a.bottom, b.bottom))
