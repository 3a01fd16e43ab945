"""A person's bodies to be drawn: the bare arm and its watch; the shirt, whose sleeve begins where the bare arm ends."""

import numpy as np

from common.geometry import Array
from local_site.simulation.body import ArmBody, BodyPose, Part, Solid
from local_site.simulation.room.config import RoomConfig
from local_site.simulation.room.layer import ShadedBody
from local_site.simulation.room.surface import STRETCHED, TONES, ArmSurface, Coat, Colour, between, reflectance

WATCH_AT = 7  # of the forearm's sections
STRAP, GLASS, GLASS_TURN = (34, 36, 40), (120, 132, 140), (-4.2, 7.0)
SHIRTS: tuple[Colour, ...] = ((58, 84, 120), (92, 104, 92), (120, 60, 62), (70, 70, 76), (188, 190, 194))
FOLDS = 0.06
SLEEVE_SECTIONS = 8  # of the forearm's nine: a long sleeve ends before the wrist
THICK_M = 0.007
WIDER = 1.10  # the sleeve than the arm
SLEEVE_SPACING, CHEST_SPACING = 0.6, 0.35
# From the right shoulder, m: the left one, the chest, the waist. The operator faces -y.
CHEST = np.array(
    [
        [0.02, 0.01, -0.01],
        [0.38, 0.01, -0.01],
        [0.06, -0.02, -0.17],
        [0.34, -0.02, -0.17],
        [0.07, 0.02, -0.50],
        [0.33, 0.02, -0.50],
    ]
)
CHEST_RADII = np.array([0.062, 0.062, 0.105, 0.105, 0.110, 0.110])


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


class Shirt:
    """The shirt's bodies by the operator's pose."""

    def __init__(self, body: ArmBody, random: np.random.Generator) -> None:
        solid = body.solid(STRETCHED)
        self._sleeve = (Part("sleeve", (np.array([0, 1]),)),)
        self._chest = (Part("chest", (np.arange(len(CHEST)),)),)
        start = np.vstack([STRETCHED.shoulder, solid.rim.mean(axis=0)])
        radius = WIDER * solid.radii.max()
        self._sleeve_weights = between(self._sleeve, start, np.full(2, radius), SLEEVE_SPACING)
        self._chest_weights = between(self._chest, CHEST, CHEST_RADII, CHEST_SPACING)
        colour = SHIRTS[random.integers(len(SHIRTS))]
        self._long_sleeve = tuple(_without_hand(part) for part in body.parts if part.name in ("upper_arm", "forearm"))
        arm = np.vstack([solid.centres, start[1]])
        self._long_weights = between(self._long_sleeve, arm, np.append(solid.radii, radius), SLEEVE_SPACING)
        self._sleeve_coat = _cloth(len(self._sleeve_weights), colour, random)
        self._long_coat = _cloth(len(self._long_weights), colour, random)
        self._chest_coat = _cloth(len(self._chest_weights), colour, random)

    def sleeve(self, pose: BodyPose, skin: Solid) -> ShadedBody:
        """From the shoulder to the arm's rim."""
        middle = skin.rim.mean(axis=0)
        rim = middle + WIDER * (skin.rim - middle)
        radius = np.linalg.norm(rim - middle, axis=1).max()
        solid = Solid(pose.shoulder[None], np.array([radius]), rim)
        return ShadedBody(solid, self._sleeve, self._sleeve_weights, np.zeros((1, 3)), self._sleeve_coat)

    def long_sleeve(self, skin: Solid) -> ShadedBody:
        """From the arm's rim to the wrist."""
        middle = skin.rim.mean(axis=0)
        solid = Solid(skin.centres, skin.radii + THICK_M, middle + WIDER * (skin.rim - middle))
        return ShadedBody(solid, self._long_sleeve, self._long_weights, np.zeros_like(skin.centres), self._long_coat)

    def chest(self, shoulder: Array) -> ShadedBody:
        """Both shoulders, chest and waist, seen from the front."""
        centres = shoulder + CHEST
        solid = Solid(centres, CHEST_RADII, np.tile(centres[0], (32, 1)))
        weights = np.pad(self._chest_weights, ((0, 0), (0, 1)))
        return ShadedBody(solid, self._chest, weights, np.zeros_like(centres), self._chest_coat)


def is_before(sleeve: ShadedBody, centre: Array) -> bool:
    """Return whether a camera at `centre` (3,) in m sees the sleeve before the arm's end, not the other way round."""
    rim, shoulder = sleeve.solid.rim.mean(axis=0), sleeve.solid.centres[0]
    return bool((centre - rim) @ (shoulder - rim) > 0.0)


def _put_on_watch(coat: Coat, surface: ArmSurface) -> None:
    """A dark strap round the wrist and bright glass on its back."""
    worn = surface.weights[:, 2 * WATCH_AT : 2 * WATCH_AT + 2].sum(axis=1) > 0.5
    coat.palm[worn], coat.back[worn], coat.turn[worn] = reflectance(STRAP), reflectance(GLASS), GLASS_TURN


def _without_hand(limb: Part) -> Part:
    """The limb's pieces as far as a sleeve reaches."""
    wrist = 2 * SLEEVE_SECTIONS
    pieces = [piece for piece in limb.pieces if limb.name == "upper_arm" or piece.max() < wrist]
    return Part(limb.name, tuple(pieces))


def _cloth(count: int, colour: Colour, random: np.random.Generator) -> Coat:
    shade = reflectance(colour) * (1.0 + FOLDS * random.standard_normal((count, 1)))
    return Coat(shade, shade, np.zeros((count, 2)))
