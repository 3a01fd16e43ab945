"""Sighting of a marker by the cameras at one time: its pose, or why there is none."""

from typing import NamedTuple

from common.geometry import Array
from remote_site.reasons import Reason


class MarkerSighting(NamedTuple):
    """A marker's pose `base_T_marker` (4 x 4) as the named views saw it, or the `refusal` in its place.

    `t_ns` is the oldest exposure that it comes from, by this host's clock.
    """

    marker: int
    t_ns: int
    base_T_marker: Array | None
    refusal: Reason | None
    views: tuple[str, ...] = ()
