"""A predictor given numbers alone, of a tool whose pose does not matter."""

import numpy as np

from common.geometry import Array
from remote_site.motion.target_predictor import TargetPredictor
from remote_site.motion.tool_sample import ToolSample

ANYWHERE = np.eye(4)


def aim(predictor: TargetPredictor, t_ns: int, q: Array, now_ns: int) -> None:
    """Give it the target's numbers (n,) for the time `t_ns`, known at `now_ns`."""
    predictor.aim(ToolSample(t_ns, now_ns, ANYWHERE, None, None), q)
