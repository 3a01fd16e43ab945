"""The arm's lengths, learned from pairs of pictures in which outlines and hand agree."""

import math
from collections import deque

import numpy as np

from local_site.tracking.silhouette.joints import Body

MOST_SPREAD = 0.06  # of the forearm's length: outlines that leak into the background vary more


class ArmLength:
    """Collects forearm lengths until enough of them agree; `body` has no lengths before."""

    def __init__(self, needed: int, forearm_m: float | None = None) -> None:
        """`forearm_m` was learned in an earlier run."""
        self._lengths_m: deque[tuple[float, float]] = deque(maxlen=needed)
        self.body = Body(forearm_m)
        self.seen = 0

    @property
    def needed(self) -> int:
        """How many pairs must agree."""
        return self._lengths_m.maxlen or 0

    @property
    def is_known(self) -> bool:
        """Whether enough pairs of this run agreed."""
        return self.seen >= self.needed

    def add(self, forearm_m: float, to_sleeve_m: float) -> None:
        """Take the lengths of one pair; the distance from elbow to sleeve is NaN where the sleeve is not seen."""
        if self.is_known:
            return
        self._lengths_m.append((forearm_m, to_sleeve_m))
        self.seen = min(self.seen + 1, self.needed - 1)
        forearms, sleeves = np.array(self._lengths_m).T
        forearm = float(np.median(forearms))
        spread = float(np.median(np.abs(forearms - forearm)))
        if len(forearms) < self.needed or spread > MOST_SPREAD * forearm:
            return
        known = sleeves[np.isfinite(sleeves)]
        sleeve = float(np.median(known)) if len(known) else math.nan
        self.body = Body(forearm, sleeve if math.isfinite(sleeve) else None)
        self.seen = self.needed
