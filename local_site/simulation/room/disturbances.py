"""What may disturb a tracker, by name: what is drawn once, and what moves."""

from typing import Protocol

import numpy as np

from common.cameras.camera import Image
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.room.bystanders import Face, SecondArm
from local_site.simulation.room.config import DisturbanceName
from local_site.simulation.room.layer import Brush
from local_site.simulation.room.moving_things import Fan, Shadows


class Disturbance(Protocol):
    """Something behind the operator on the pictures (H, W, 3) of one camera."""

    def stand(self, image: Image) -> None:
        """Draw what never moves."""

    def move(self, image: Image, filmed_s: float) -> None:
        """Draw what moves, at a time in s since the cameras began."""


def make_disturbances(
    names: tuple[DisturbanceName, ...], camera: PinholeCamera, brush: Brush, size: tuple[int, int], seed: int
) -> list[Disturbance]:
    """Those that are not part of the room itself, the farthest first, the same for all cameras of one seed."""
    made: dict[DisturbanceName, Disturbance] = {
        "fan": Fan(camera),
        "shadows": Shadows(size, np.random.default_rng(seed)),
        "face": Face(brush, camera, np.random.default_rng(seed)),
        "second_arm": SecondArm(brush, np.random.default_rng(seed)),
    }
    return [disturbance for name, disturbance in made.items() if name in names]
