"""What the simulated operator's cameras give at successive instants, as views or as cameras."""

from collections.abc import Iterator

import numpy as np

from common.cameras.camera import Frame, Image
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.tracker import View, Views

PERIOD_NS = 33_333_333


def filmed(count: int) -> list[list[Image]]:
    """The left and the right picture of so many instants."""
    operator = SimulatedOperator(SimulationConfig())
    return [operator.render(k * PERIOD_NS * 1e-9, (0, 1)) for k in range(count)]


def views_of(instants: list[list[Image]]) -> Iterator[Views]:
    """The same as views, a period apart."""
    for k, pictures in enumerate(instants):
        yield Views(k * PERIOD_NS, tuple(View(Frame(picture, k * PERIOD_NS, k)) for picture in pictures))


def before_a_wall(instants: list[list[Image]], level: int) -> list[list[Image]]:
    """The same before a bright wall of this grey level."""
    return [[np.maximum(picture, np.uint8(level)) for picture in pictures] for pictures in instants]


class FilmedCamera:
    """Gives pictures once, stamped a period apart."""

    def __init__(self, name: str, pictures: list[Image]) -> None:
        self.name = name
        self._frames = [Frame(picture, k * PERIOD_NS, k) for k, picture in enumerate(pictures)]

    def read(self) -> Frame | None:
        return self._frames.pop(0) if self._frames else None

    def close(self) -> None:
        """Nothing is held open."""
