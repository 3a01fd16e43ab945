"""The leash: how far the tool's target may be ahead of the arm, by what was sent and by what is measured; pure."""

import math

from common.geometry import Array, angle_between, pose_between
from remote_site.reasons import Code, Reason, reason

EXACT = 1e-9  # m or rad: rounding is no lead
HALVINGS = 8  # of the way of one sample: what is left of it is less than anything that moves


class Leash:
    """Holds targets within `distance_m` and `angle_rad` of the tool, as sent and as measured, whichever allows less.

    A target is drawn towards the tool as it was sent, where the arm is led. What is measured only ever holds it back:
    a reading that is wrong but plausible cannot draw it away from the way between the target before and the wanted one.
    """

    def __init__(self, distance_m: float, angle_rad: float) -> None:
        self._distance_m, self._angle_rad = distance_m, angle_rad

    def hold(self, wanted: Array, former: Array, sent: Array, measured: Array) -> tuple[Array, Reason | None]:
        """The target for the `wanted` one, after the `former` one (all 4 x 4), and why where it is another."""
        target = self._drawn(wanted, sent)
        if not self._reaches(target, measured, measured):
            target = self._led_on(former, target, measured)
        if target is wanted:
            return wanted, None
        ahead_m, left_m = (max(_way(pose, arm)[0] for arm in (sent, measured)) for pose in (wanted, target))
        return target, reason(Code.SATURATED, distance_mm=1e3 * ahead_m, limit_mm=1e3 * left_m)

    def _drawn(self, wanted: Array, sent: Array) -> Array:
        """The wanted target drawn towards the tool as sent until it is within both limits."""
        distance, angle = _way(wanted, sent)
        within = self._distance_m / max(distance, self._distance_m), self._angle_rad / max(angle, self._angle_rad)
        return wanted if min(within) >= 1.0 else pose_between(sent, wanted, min(within))

    def _led_on(self, former: Array, target: Array, measured: Array) -> Array:
        """The last pose on the way to a target that is not farther from the measured tool than is allowed."""
        least, most = 0.0, 1.0
        for _ in range(HALVINGS):
            fraction = (least + most) / 2
            if self._reaches(pose_between(former, target, fraction), measured, former):
                least = fraction
            else:
                most = fraction
        return pose_between(former, target, least)

    def _reaches(self, target: Array, measured: Array, former: Array) -> bool:
        """Return whether a target is within both limits of the measured tool, or no farther from it than the former."""
        ways = zip(_way(target, measured), _way(former, measured), (self._distance_m, self._angle_rad), strict=True)
        return all(way <= max(before, limit) + EXACT for way, before, limit in ways)


def _way(a: Array, b: Array) -> tuple[float, float]:
    """The distance in m and the angle in rad between two poses (4 x 4)."""
    return math.dist(a[:3, 3].tolist(), b[:3, 3].tolist()), angle_between(a[:3, :3], b[:3, :3])
