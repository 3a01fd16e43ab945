"""The arm before a wall that is darker than it: a threshold which follows slow changes of the light."""

from common.cameras.camera import Image
from local_site.tracking.features.silhouette import Silhouette, find_silhouette, find_threshold

UPDATE_EVERY = 15
UPDATE_GAIN = 0.3


class DarkWall:
    """Gives the silhouettes of one camera: what is brighter than a level between the wall's and the arm's."""

    def __init__(self) -> None:
        self._level: float | None = None
        self._since = 0

    def silhouette(self, grey: Image) -> Silhouette | str:
        """The arm in a smoothed grey picture (H, W), or a sentence with the reason why there is none."""
        level = self._threshold(grey)
        if isinstance(level, str):
            return level
        return find_silhouette(grey, level) or "no arm in the picture"

    def forget(self) -> None:
        """Find the threshold again with the next picture."""
        self._level = None

    def _threshold(self, grey: Image) -> float | str:
        """The threshold, updated every few pictures by a low-pass filter, or why there is none yet.

        A later picture without two clear modes changes nothing: the arm may just have left it.
        """
        self._since += 1
        if self._level is not None and self._since < UPDATE_EVERY:
            return self._level
        self._since = 0
        found = find_threshold(grey)
        if self._level is None:
            if isinstance(found, str):
                return found
            self._level = found
        elif not isinstance(found, str):
            self._level += UPDATE_GAIN * (found - self._level)
        return self._level
