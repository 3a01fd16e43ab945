"""One target of the tool, as it comes from a hand sample; pure."""

from dataclasses import dataclass

from common.geometry import Array
from remote_site.reasons import Reason


@dataclass(frozen=True, slots=True)
class ToolSample:
    """A target of the tool from one hand sample.

    `base_T_target` (4 x 4) holds for the time `t_ns` and is known since `now_ns`; `elbow` is the operator's from the
    wrist (3,) in m in the base's axes, None while it is not seen; `leashed` is why the leash holds the target (then
    it moves only with the arm), `boxed` why the workspace's box does; both None while they do not. It is extrapolated
    `stretch` times as long as configured. `spare` is the fraction of the catch-up speed (`catch_up.py`) with which it
    does not move itself, `speed` the fraction of full speed at which the arm follows: a slowed one is hurried by less.
    """

    t_ns: int
    now_ns: int
    base_T_target: Array
    elbow: Array | None
    leashed: Reason | None
    stretch: float = 1.0
    spare: float = 1.0
    speed: float = 1.0
    boxed: Reason | None = None
