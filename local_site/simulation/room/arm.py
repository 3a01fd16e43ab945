"""The arm as a body to be drawn: bare skin, and what is worn on it."""

import numpy as np

from local_site.simulation.body import ArmBody, BodyPose
from local_site.simulation.room.config import RoomConfig
from local_site.simulation.room.layer import ShadedBody
from local_site.simulation.room.skin import TONES, reflectance
from local_site.simulation.room.surface import ArmSurface, Coat

WATCH_AT = 7  # of the forearm's sections
STRAP, GLASS, GLASS_TURN = (34, 36, 40), (120, 132, 140), (-4.2, 7.0)


class Arm:
    """A bare arm's body by its pose."""

    def __init__(self, body: ArmBody, room: RoomConfig, random: np.random.Generator) -> None:
        self._body = body
        self._surface = ArmSurface(body)
        self._coat = self._surface.coat(TONES[room.skin], random)
        if room.watch:
            _put_on_watch(self._coat, self._surface)

    def posed(self, pose: BodyPose) -> ShadedBody:
        """The arm in a pose."""
        solid = self._body.solid(pose)
        return ShadedBody(solid, self._body.parts, self._surface.weights, self._body.backs(pose), self._coat)


def _put_on_watch(coat: Coat, surface: ArmSurface) -> None:
    """A dark strap round the wrist and bright glass on its back."""
    worn = surface.weights[:, 2 * WATCH_AT : 2 * WATCH_AT + 2].sum(axis=1) > 0.5
    coat.palm[worn], coat.back[worn], coat.turn[worn] = reflectance(STRAP), reflectance(GLASS), GLASS_TURN
