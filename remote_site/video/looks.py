"""What a camera's pictures tell of it: whether they are dark, and how many a second there really are. Pure."""

from collections import deque

import cv2

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, NS_PER_S

WINDOW_NS = 700 * NS_PER_MS
FLAT = 3.0


def is_dark(image: Image, dark_level: float) -> bool:
    """Whether nothing can be seen in a picture: nearly all of it is below a level of brightness, or all is alike.

    Nearly all is the mean and two standard deviations of the brightness, 0 to 255.
    """
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    mean, deviation = cv2.meanStdDev(grey)
    brightness, contrast = float(mean[0, 0]), float(deviation[0, 0])
    return contrast < FLAT or brightness + 2.0 * contrast < dark_level


class FrameRate:
    """How many pictures a second a camera makes, by its own numbers, whether or not all were taken."""

    def __init__(self) -> None:
        self._exposures: deque[tuple[int, int]] = deque()

    def see(self, frame: Frame) -> None:
        """A new picture; numbers that begin anew, as after a camera was opened again, begin a new count."""
        if self._exposures and frame.seq <= self._exposures[-1][1]:
            self._exposures.clear()
        self._exposures.append((frame.capture_ns, frame.seq))
        while len(self._exposures) > 1 and self._exposures[1][0] <= frame.capture_ns - WINDOW_NS:
            self._exposures.popleft()

    @property
    def fps(self) -> float | None:
        """Pictures a second of late, None before there were enough to tell."""
        if not self._exposures:
            return None
        (first_ns, first), (last_ns, last) = self._exposures[0], self._exposures[-1]
        return (last - first) * NS_PER_S / (last_ns - first_ns) if last_ns - first_ns >= WINDOW_NS else None
