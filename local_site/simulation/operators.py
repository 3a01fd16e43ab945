"""Which operator is simulated: what they have in common, and how one is made."""

from collections.abc import Mapping
from typing import Protocol

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.rig import Rig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hazel import film_camera
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.textured_operator import TexturedOperator


class Operator(Protocol):
    """Somebody who moves before cameras; times are s since the start of the motion.

    `points` are those that a tracker measures, by name, (3,) in m in the operator frame.
    """

    def render(self, t_s: float, cameras: tuple[int, ...]) -> list[Image]: ...

    def points(self, t_s: float) -> Mapping[str, Array]: ...

    def openings_until(self, t_s: float) -> int: ...


def make_operator(config: SimulationConfig) -> Operator:
    """The operator that the configuration asks for; ConfigError when the motion is out of the arm's reach."""
    return TexturedOperator(config.motion.still_s) if config.textured else SimulatedOperator(config)


def filming_rig(config: SimulationConfig) -> Rig:
    """The cameras that film this operator, without any error."""
    return film_camera() if config.textured else exact_rig(config.stereo)
