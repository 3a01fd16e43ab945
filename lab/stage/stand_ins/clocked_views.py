"""Runs Farhand's command line with simulated views of the cell that show when they were exposed, for a machine to read.

python -m lab.stage.stand_ins.clocked_views remote --set ...
"""

from dataclasses import replace
from unittest.mock import patch

from common.cameras.camera import Frame
from farhand.__main__ import main
from lab.stage.clock_strip import draw_clock
from remote_site.video import cell_cameras


class ClockedCamera(cell_cameras.CellCamera):
    """A view of the cell with the instant of its exposure along its top (clock_strip)."""

    _clocked: Frame | None = None

    def newest(self) -> Frame | None:
        """The view of the newest posture, and its instant; None before the cell's first step."""
        frame = super().newest()
        if frame is not None and (self._clocked is None or self._clocked.seq != frame.seq):
            image = frame.image.copy()
            draw_clock(image, frame.capture_ns)
            self._clocked = replace(frame, image=image)
        return self._clocked


def run() -> None:
    """The command line of Farhand, with clocks in the simulated views."""
    with patch.object(cell_cameras, "CellCamera", ClockedCamera):
        main()


if __name__ == "__main__":
    run()
