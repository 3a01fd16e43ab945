"""Shift of the tool by joints, each alone and all together, and where they cancel each other; pure."""

import math

from common.geometry import Array
from remote_site.kinematics.model import ArmModel

WRIST_ROLLS = [3, 5]  # joints 4 and 6 swing far where the wrist is straight, and hardly move the tool there
NOTHING = 1e-9


class ToolShift:
    """The way of the tool's position with the joints of an arm with a spherical wrist.

    The noise of samples turns the wrist most: joints 4 and 6 count for how far the tool is off, not for its way there.
    """

    def __init__(self, model: ArmModel) -> None:
        self._model = model

    def lever(self, q: Array) -> Array:
        """Compute how far each joint but 4 and 6 moves the tool (3, n) in m/rad at `q` (n,) rad."""
        lever: Array = self._model.jacobian(q)[:3]
        lever[:, WRIST_ROLLS] = 0.0
        return lever

    def speed_m_s(self, q: Array, dq: Array) -> float:
        """Compute how fast the tool moves when the joints are at `q` and move with `dq`."""
        return math.hypot(*(self._model.jacobian(q)[:3] @ dq).tolist())

    def between_m(self, q: Array, at: Array) -> float:
        """Compute how far the tool is from where it would be at `q`, for joints near there at `at`."""
        return math.hypot(*(self._model.jacobian(at)[:3] @ (q - at)).tolist())

    def by_rolls_m(self, q: Array, at: Array) -> float:
        """Compute how far joints 4 and 6 alone move the tool on their way to `q`, for joints near there at `at`."""
        return math.hypot(*(self._model.jacobian(at)[:3, WRIST_ROLLS] @ (q - at)[WRIST_ROLLS]).tolist())

    def stretch(self, q: Array) -> float:
        """Compute how many times faster than the tool, at most, one joint alone moves it while others take it back.

        At least 1; infinite where the elbow is straight. For the columns a, b, c of joints 1 to 3, a alone moves
        it by up to |a| |b x c| / |det| per way of the tool, and so on. From their products, |b x c|^2 is bb cc - bc bc,
        and det^2 their determinant.
        """
        lever = self.lever(q)[:, :3]
        (aa, ab, ac), (_, bb, bc), (_, _, cc) = (lever.T @ lever).tolist()
        det = aa * (bb * cc - bc * bc) - ab * (ab * cc - bc * ac) + ac * (ab * bc - bb * ac)
        most = max(aa * (bb * cc - bc * bc), bb * (aa * cc - ac * ac), cc * (aa * bb - ab * ab))
        return math.sqrt(most / det) if det > NOTHING**2 else math.inf


def fastest_alone(moved: Array) -> float:
    """The greatest speed in m/s that one joint alone gives the tool, from each joint's part (3, n) of its velocity."""
    return math.sqrt(float((moved * moved).sum(axis=0).max()))
