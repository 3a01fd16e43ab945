"""The simulated operator's right arm as a solid, bare or with markers: hulls of balls, posed by a skeleton."""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array, skew
from local_site.simulation.config import BodyConfig, MarkersWorn
from local_site.simulation.hand import DIGITS, JOINTS, U_SHAPE, FingerPosture, Hand, unit

RIM_POINTS = 32
OPEN_ABOVE = 0.5

FOREARM_AT = np.array([0.03, 0.1, 0.2, 0.32, 0.45, 0.6, 0.75, 0.88, 1.0])
FOREARM_BELLY = np.array([0.0, 0.7, 1.0, 1.0, 0.72, 0.36, 0.12, 0.02, 0.0])
# The axis of the elbow lies nearer to the back of the arm, so the limbs lie before it, and the more so at the bellies.
FOREARM_BEFORE = np.array([0.75, 0.9, 1.0, 1.0, 0.85, 0.55, 0.25, 0.08, 0.0])
UPPER_ARM_BEFORE = np.array([0.75, 0.85, 0.95, 1.0, 1.0])
UPPER_ARM_AT = np.array([0.04, 0.15, 0.35, 0.6, 1.0])
UPPER_ARM_BELLY = np.array([0.0, 0.35, 0.75, 1.0, 0.9])
BELLY_AT = 0.26
WRIST_FLATNESS = 0.42
ELBOW_FLATNESS = 0.10
MARKER_RADIUS_M = 0.012
# Beside a tip a smaller one, of which the finger hides less.
MARKER_BESIDE_RADIUS_M = 0.006
# Half the width of a wrist: the thesis's markers sit on the radial side of it (section 5.2).
WRIST_MARKER_IN_HAND = np.array([0.0, 0.033, 0.0])


@dataclass(frozen=True, slots=True)
class BodyPose:
    """The skeleton at one instant, operator frame, m.

    `operator_R_hand` has its columns along the hand: x distal, y radial (the thumb's side), z dorsal.
    `openness` is 0 in the hand's posture at rest and 1 with all fingers spread.
    """

    shoulder: Array
    elbow: Array
    wrist: Array
    operator_R_hand: Array
    openness: float


@dataclass(frozen=True, slots=True)
class ArmTruth:
    """The truth that a tracker should find, operator frame, m: joint centres, and the tips on the skin."""

    elbow: Array
    wrist: Array
    index: Array
    thumb: Array
    hand_open: bool


@dataclass(frozen=True)
class Part:
    """A limb that is drawn as one: each of its pieces is the convex hull of these balls.

    The rim comes after the last ball, then the markers; a marker is `worn_on` a limb at one of its balls.
    """

    name: str
    pieces: tuple[NDArray[np.intp], ...]
    worn_on: "tuple[Part, int] | None" = None

    @cached_property
    def sizes(self) -> NDArray[np.intp]:
        """How many balls each piece has."""
        return np.array([len(piece) for piece in self.pieces])

    @cached_property
    def balls(self) -> NDArray[np.intp]:
        """All balls of the part, those of several pieces several times."""
        return np.concatenate(self.pieces)


@dataclass(frozen=True, slots=True)
class Solid:
    """The skin: balls (N, 3) with radii (N,), the sleeve's rim (M, 3), markers (K, 3); all in the operator frame, m."""

    centres: Array
    radii: Array
    rim: Array
    markers: Array = field(default_factory=lambda: np.empty((0, 3)))
    marker_radius: float = 0.0


class ArmBody:
    """One person's arm: turns a pose into a solid and into the truth."""

    def __init__(self, config: BodyConfig, rest: FingerPosture = U_SHAPE) -> None:
        self._config = config
        self._hand = Hand(config.hand_scale, rest)
        taper = config.elbow_girth + (config.wrist_girth - config.elbow_girth) * FOREARM_AT
        bulge = config.forearm_girth - float(np.interp(BELLY_AT, FOREARM_AT, taper))
        flatness = ELBOW_FLATNESS + (WRIST_FLATNESS - ELBOW_FLATNESS) * FOREARM_AT**2
        forearm = _stadium(taper + bulge * FOREARM_BELLY, flatness)
        girth = config.elbow_girth + (config.upper_arm_girth - config.elbow_girth) * UPPER_ARM_BELLY
        upper_arm = _stadium(girth, np.full(len(girth), ELBOW_FLATNESS))
        self._radii = np.concatenate(
            [np.repeat(forearm.radius, 2), np.repeat(upper_arm.radius[:-1], 2), self._hand.radii]
        )
        self._forearm_middle = np.repeat(
            _middles(config.forearm_length * FOREARM_AT, config.belly_offset * FOREARM_BEFORE), 2, axis=0
        )
        self._forearm_half_width = _pairs(forearm.half_width)
        self._forearm_twist = np.repeat(FOREARM_AT**1.3, 2)
        reach = config.upper_arm_length * config.bare_fraction * UPPER_ARM_AT
        self._upper_arm_in_limb = _upper_arm(_middles(reach, config.belly_offset * UPPER_ARM_BEFORE), upper_arm)
        self.parts = _parts(len(FOREARM_AT), len(UPPER_ARM_AT) - 1)
        self.ball_count = len(self._radii)

    def solid(self, pose: BodyPose) -> Solid:
        """The skin of the whole arm in this pose."""
        along, up = unit(np.array([pose.wrist - pose.elbow, pose.elbow - pose.shoulder]))
        hinge = unit(_cross(along, up))
        forearm = self._forearm_balls(pose, np.array([along, hinge, _cross(along, hinge)]))
        upper = pose.elbow + self._upper_arm_in_limb @ np.array([-up, hinge, _cross(up, hinge)])
        hand = pose.wrist + self._hand.balls(pose.openness) @ pose.operator_R_hand.T
        return Solid(np.concatenate([forearm, upper[:-RIM_POINTS], hand]), self._radii, upper[-RIM_POINTS:])

    def truth(self, pose: BodyPose) -> ArmTruth:
        """The points of the skeleton that a tracker measures."""
        index, thumb = self._hand.tips(pose.openness)
        rotation = pose.operator_R_hand
        return ArmTruth(
            elbow=pose.elbow,
            wrist=pose.wrist,
            index=pose.wrist + rotation @ index,
            thumb=pose.wrist + rotation @ thumb,
            hand_open=pose.openness > OPEN_ABOVE,
        )

    def backs(self, pose: BodyPose) -> Array:
        """Unit vectors (N, 3) out of the back of the limb at each ball; (0, 0, 0) for the upper arm, which has none."""
        bones = self._hand.backs(pose.openness)
        digits = np.concatenate([bones, bones[:, 2:]], axis=1).reshape(-1, 3) @ pose.operator_R_hand.T
        dorsal = pose.operator_R_hand[:, 2]
        upper_arm = np.zeros((2 * len(UPPER_ARM_AT) - 2, 3))
        return np.vstack([np.tile(dorsal, (2 * len(FOREARM_AT), 1)), upper_arm, digits, np.tile(dorsal, (4, 1))])

    def joints(self, pose: BodyPose) -> Array:
        """Joint centres (5, 4, 3) of index, middle, ring, little finger and thumb, from base to tip."""
        return pose.wrist + self._hand.joints(pose.openness) @ pose.operator_R_hand.T

    def beside_tips(self, pose: BodyPose) -> Array:
        """Return the centres (2, 3) of markers beside the tips of index and thumb, operator frame, m."""
        return pose.wrist + self._hand.beside_tips(pose.openness) @ pose.operator_R_hand.T

    def _forearm_balls(self, pose: BodyPose, limb: Array) -> Array:
        """Pairs of balls (2N, 3): flat across the hinge at the elbow, across the hand at the wrist.

        `limb` has in its rows the forearm's direction, the hinge's, and that out of the elbow's inner side.
        """
        radial = limb @ pose.operator_R_hand[:, 1]
        twist = math.atan2(radial[2], radial[1])
        if twist < -math.pi / 2:
            twist += 2 * math.pi
        angle = twist * self._forearm_twist
        in_limb = self._forearm_middle.copy()
        in_limb[:, 1] += self._forearm_half_width * np.cos(angle)
        in_limb[:, 2] += self._forearm_half_width * np.sin(angle)
        balls: Array = pose.elbow + in_limb @ limb
        return balls


class MarkedArm:
    """An arm that wears a dark glove and bright balls on the wrist's radial side, on index and thumb.

    Those of the fingers are `worn` as caps about the last joint, so that they show from all sides, or beside the tips.
    The truth for wrist, index and thumb is the centres of the markers.
    """

    def __init__(self, body: ArmBody, worn: MarkersWorn = "round_the_tips") -> None:
        self._body = body
        self._round_tips = worn == "round_the_tips"
        self._radius = MARKER_RADIUS_M if self._round_tips else MARKER_BESIDE_RADIUS_M
        by_name = {part.name: part for part in body.parts}
        self._tips = [int(by_name[name].balls[-1]) for name in ("index", "thumb")]
        wrist = 2 * len(FOREARM_AT) - 1
        self.parts = body.parts + tuple(
            Part(f"{name} marker", (np.array([body.ball_count + 1 + k]),), worn_on=(limb, ball))
            for k, (name, limb, ball) in enumerate(
                [
                    ("wrist", by_name["forearm"], wrist),
                    ("index", by_name["index"], self._tips[0]),
                    ("thumb", by_name["thumb"], self._tips[1]),
                ]
            )
        )

    def solid(self, pose: BodyPose) -> Solid:
        """The skin of the whole arm in this pose, with its markers."""
        skin = self._body.solid(pose)
        return replace(skin, markers=self._centres(pose, skin), marker_radius=self._radius)

    def truth(self, pose: BodyPose) -> ArmTruth:
        """The elbow, and the centres of the markers."""
        wrist, index, thumb = self._centres(pose, self._body.solid(pose))
        return replace(self._body.truth(pose), wrist=wrist, index=index, thumb=thumb)

    def _centres(self, pose: BodyPose, skin: Solid) -> Array:
        wrist = pose.wrist + pose.operator_R_hand @ WRIST_MARKER_IN_HAND
        return np.vstack([wrist, skin.centres[self._tips] if self._round_tips else self._body.beside_tips(pose)])


@dataclass(frozen=True, slots=True)
class _Sections:
    """Cross-sections of a limb, each two half circles of `radius` whose centres lie 2 `half_width` apart, m."""

    radius: Array
    half_width: Array


def _stadium(girth: Array, flatness: Array) -> _Sections:
    """Sections of this girth, 2 pi r + 4 w, whose half width w is `flatness` times the radius."""
    radius = girth / (2 * np.pi + 4 * flatness)
    return _Sections(radius, flatness * radius)


def _middles(reach: Array, before: Array) -> Array:
    """The middles (N, 3) of a limb's sections, so far from the elbow and before its axis, in the limb's directions:
    along it, along the hinge, and out of the elbow's inner side."""
    return np.column_stack([reach, np.zeros(len(reach)), before])


def _pairs(half_width: Array) -> Array:
    """How far aside (2N,) the two balls of each section are."""
    return np.column_stack([-half_width, half_width]).ravel()


def _upper_arm(middles: Array, sections: _Sections) -> Array:
    """Pairs of balls from the elbow up, and the rim (RIM_POINTS, 3) where the sleeve begins: a flat cut across it.

    Both from the elbow, in the limb's directions.
    """
    balls = np.repeat(middles[:-1], 2, axis=0)
    balls[:, 1] += _pairs(sections.half_width[:-1])
    turn = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
    rim = np.tile(middles[-1], (RIM_POINTS, 1))
    rim[:, 1] += sections.radius[-1] * np.cos(turn) + sections.half_width[-1] * np.sign(np.cos(turn))
    rim[:, 2] += sections.radius[-1] * np.sin(turn)
    return np.concatenate([balls, rim])


def _cross(a: Array, b: Array) -> Array:
    """The cross product of two vectors (3,); NumPy's takes ten times as long for so few numbers."""
    return skew(a) @ b


def _parts(forearm: int, upper_arm: int) -> tuple[Part, ...]:
    """List which balls make which piece, for these numbers of sections."""
    wrist = (2 * forearm - 2, 2 * forearm - 1)
    first = 2 * (forearm + upper_arm)
    digit = {name: tuple(range(first + JOINTS * k, first + JOINTS * (k + 1))) for k, name in enumerate(DIGITS)}
    palm = first + JOINTS * len(DIGITS)
    rim = palm + 4
    knuckles = tuple(digit[name][0] for name in DIGITS[:4])
    thumb, index = digit["thumb"], digit["index"]
    hand = (
        (*wrist, *knuckles),
        (*wrist, palm, digit["little"][0]),
        (*wrist, thumb[0]),
        (thumb[0], index[0]),
        thumb[:2],
        (thumb[0], thumb[1], palm + 1),
        (thumb[0], palm + 2, palm + 3),
    )
    upper = (*_chain(2 * forearm, upper_arm), (first - 2, first - 1, rim))
    fingers = (_part(name, *pairwise(digit[name])) for name in DIGITS[:4])
    return (
        _part("upper_arm", *upper),
        _part("forearm", *_chain(0, forearm), *hand),
        *fingers,
        _part("thumb", thumb[1:3], thumb[2:]),
    )


def _part(name: str, *pieces: tuple[int, ...]) -> Part:
    return Part(name, tuple(np.array(piece) for piece in pieces))


def _chain(first: int, sections: int) -> tuple[tuple[int, ...], ...]:
    """Pieces between successive sections of two balls each."""
    return tuple(tuple(range(first + 2 * k, first + 2 * k + 4)) for k in range(sections - 1))
