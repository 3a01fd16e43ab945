"""Runs 'farhand remote' with cameras that play known pictures, in a loop: as a real camera would, at 30 a second.

python -m lab.stage.stand_ins.played_remote FOLDER --set ...

The folder has NAME.npy for each camera: (N, H, W, 3) uint8, BGR. The exposure tells which picture it was.
"""

import sys
import time
from pathlib import Path
from unittest.mock import patch

import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from farhand.__main__ import main
from remote_site.video import process
from remote_site.video.config import VideoConfig
from remote_site.video.sources import FrameSource, SimulatedViews

FPS = 30
FRAME_NS = NS_PER_S // FPS


def number_of(capture_ns: int, count: int) -> int:
    """Which of `count` pictures was exposed at a time."""
    return capture_ns // FRAME_NS % count


class PlayedCamera:
    """The `FrameSource` of a recording; cameras expose one after the other, as those without synchronisation do."""

    noise_free = False

    def __init__(self, name: str, images: Image, phase_ns: int) -> None:
        self.name = name
        self._images, self._phase_ns = images, phase_ns
        self._frame: Frame | None = None

    def newest(self) -> Frame:
        """The picture that was exposed last."""
        seq = (time.monotonic_ns() - self._phase_ns) // FRAME_NS
        if self._frame is None or self._frame.seq != seq:
            capture_ns = seq * FRAME_NS + self._phase_ns
            image = np.array(self._images[number_of(capture_ns, len(self._images))])
            self._frame = Frame(image, capture_ns, seq)
        return self._frame

    def close(self) -> None:
        """Nothing is held open."""


def run() -> None:
    """The command line of Farhand, with played cameras."""
    folder = Path(sys.argv.pop(1))

    def open_sources(config: VideoConfig, _: SimulatedViews | None, _lost: object) -> list[FrameSource]:
        names = [camera.name for camera in config.cameras]
        phase_ns = FRAME_NS // len(names)
        images = [np.load(folder / f"{name}.npy", mmap_mode="r") for name in names]
        return [PlayedCamera(*camera, k * phase_ns) for k, camera in enumerate(zip(names, images, strict=True))]

    sys.argv.insert(1, "remote")
    with patch.object(process, "open_sources", open_sources):
        main()


if __name__ == "__main__":
    run()
