"""The gate of a live calibration: a board's pose is taken once it is still, and unlike all that were taken before."""

from collections.abc import Sequence

import numpy as np

from local_site.calibration.boards import BoardView

Pose = Sequence[BoardView | None]

STILL_PX = 1.0
STILL_FRAMES = 5
NEW_PX = 30.0
MIN_CAMERAS = 2


class PoseGate:
    """Is shown what all cameras see at an instant, and says when that is a pose to keep."""

    def __init__(self, still_px: float = STILL_PX, still_frames: int = STILL_FRAMES, new_px: float = NEW_PX) -> None:
        self._still_px, self._still_frames, self._new_px = still_px, still_frames, new_px
        self._last: Pose = ()
        self._still = 0
        self._taken: list[Pose] = []

    @property
    def taken(self) -> list[Pose]:
        """The poses kept so far."""
        return list(self._taken)

    def offer(self, pose: Pose) -> bool:
        """Whether this pose is kept: seen by two cameras, still for some frames, and new to one of the cameras."""
        seen = sum(view is not None for view in pose) >= MIN_CAMERAS
        self._still = self._still + 1 if seen and self._unmoved(pose) else 0
        self._last = pose if seen else ()
        if self._still < self._still_frames or any(moved(pose, old) < self._new_px for old in self._taken):
            return False
        self._taken.append(pose)
        self._still = 0
        return True

    def _unmoved(self, pose: Pose) -> bool:
        return bool(self._last) and moved(pose, self._last) < self._still_px


def moved(pose: Pose, other: Pose) -> float:
    """How far the corners moved on average, px, in the camera where they moved most; infinite if none is in both."""
    distances = [_distance(a, b) for a, b in zip(pose, other, strict=True) if a is not None and b is not None]
    return max(distances, default=np.inf)


def _distance(a: BoardView, b: BoardView) -> float:
    _, mine, theirs = np.intersect1d(a.ids, b.ids, return_indices=True)
    if len(mine) == 0:
        return float(np.inf)
    return float(np.mean(np.linalg.norm(a.pixels[mine] - b.pixels[theirs], axis=1)))
