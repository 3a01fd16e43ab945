"""Pictures from one process to another: a ring in shared memory of which the reader takes the newest."""

import mmap

import numpy as np

from common.cameras.camera import Frame, Image

SLOTS = 4
WRITING = -1


class FrameRing:
    """A few pictures of one camera, for one writer and any readers, which inherit it by fork.

    A slot's number is `WRITING` while its picture changes; a reader that finds the number changed reads anew.
    """

    def __init__(self, width_px: int, height_px: int) -> None:
        stamp_bytes = 8 * (2 * SLOTS + 1)
        memory = mmap.mmap(-1, stamp_bytes + SLOTS * width_px * height_px)
        stamps = np.frombuffer(memory, np.int64, 2 * SLOTS + 1)
        self._newest, self._numbers, self._times_ns = stamps[:1], stamps[1 : SLOTS + 1], stamps[SLOTS + 1 :]
        pixels = np.frombuffer(memory, np.uint8, offset=stamp_bytes)
        self._pictures = pixels.reshape(SLOTS, height_px, width_px)
        self._newest[0] = -1
        self._numbers[:] = WRITING

    def publish(self, image: Image, capture_ns: int) -> None:
        """Make this picture (H, W) the newest."""
        number = int(self._newest[0]) + 1
        slot = number % SLOTS
        self._numbers[slot] = WRITING
        self._pictures[slot] = image
        self._times_ns[slot] = capture_ns
        self._numbers[slot] = number
        self._newest[0] = number

    def newest(self, after: int) -> Frame | None:
        """A copy of the newest picture, None when its number is not above `after`."""
        while (number := int(self._newest[0])) > after:
            slot = number % SLOTS
            frame = Frame(self._pictures[slot].copy(), int(self._times_ns[slot]), number)
            if int(self._numbers[slot]) == number:
                return frame
        return None
