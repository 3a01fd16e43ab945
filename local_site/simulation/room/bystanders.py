"""Other people in the picture: a second bare arm, which is a left one, and a face in the background."""

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array, rotation_from_vector
from local_site.simulation.body import ArmBody, Part, Solid
from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.config import BodyConfig, MotionConfig
from local_site.simulation.motion import Motion
from local_site.simulation.room.config import RoomConfig
from local_site.simulation.room.layer import Brush, ShadedBody
from local_site.simulation.room.person import Arm, Shirt
from local_site.simulation.room.surface import TONES, Coat, Colour, between, reflectance

# The second arm comes in from the other side: its x is mirrored, then it is moved, m.
MIRROR, BESIDE = np.array([-1.0, 1.0, 1.0]), np.array([0.60, 0.30, -0.22])
WAVE_S = 5.0
FACE_AT, SHOULDER_AT = np.array([0.16, 1.30, 0.70]), np.array([-0.03, 1.32, 0.47])
SWAY_M, SWAY_S = 0.05, 6.0
# Skull, brow, cheeks, jaw, neck, then hair; from the skull's middle, m.
HEAD = np.array(
    [
        [0.0, 0.0, 0.0],
        [0.0, -0.035, 0.02],
        [0.0, -0.030, -0.07],
        [0.0, 0.02, -0.16],
        [0.0, 0.012, 0.022],
        [0.0, 0.03, -0.02],
    ]
)
HEAD_RADII = np.array([0.082, 0.060, 0.052, 0.055, 0.086, 0.086])
FACE_PIECES = (np.array([0, 1, 2]), np.array([0, 3]))
HAIR_PIECES = (np.array([4, 5]),)
EYES = np.array([[-0.031, -0.100, -0.012], [0.031, -0.100, -0.012]])
MOUTH = np.array([[-0.022, -0.086, -0.078], [0.022, -0.086, -0.078]])
HAIR: Colour = (52, 40, 32)
EYE, LIPS = (40, 36, 34), (92, 84, 140)


class SecondArm:
    """A bare left arm that comes in from the other side and moves."""

    def __init__(self, brush: Brush, random: np.random.Generator) -> None:
        self._brush = brush
        self._motion = Motion(MotionConfig(name="figure_of_eight", still_s=0.0, posture="flat"), BodyConfig(), seed=2)
        body = ArmBody(BodyConfig())
        self._arm = Arm(body, RoomConfig(scene="office", skin="medium"), random)
        self._shirt = Shirt(body, random)

    def stand(self, image: Image) -> None:
        """None of it keeps still."""

    def move(self, image: Image, filmed_s: float) -> None:
        """Draw the arm as it is now."""
        pose = self._motion.pose(filmed_s)
        turn = rotation_from_vector(np.array([0.0, 0.25 * np.sin(2.0 * np.pi * filmed_s / WAVE_S), 0.0]))
        body = self._arm.posed(replace(pose, operator_R_hand=turn @ pose.operator_R_hand))
        for part in (self._shirt.sleeve(pose, body.solid), body):
            solid = replace(part.solid, centres=_beside(part.solid.centres), rim=_beside(part.solid.rim))
            self._brush.draw(image, [replace(part, solid=solid, backs=part.backs * MIRROR)])


class Face:
    """A person who stands in the background and moves the head."""

    def __init__(self, brush: Brush, camera: PinholeCamera, random: np.random.Generator) -> None:
        self._brush, self._camera = brush, camera
        self._chest = Shirt(ArmBody(BodyConfig()), random).chest(SHOULDER_AT)
        tone = TONES["light"]
        self._skin, self._hair = _head_part(FACE_PIECES, tone.back), _head_part(HAIR_PIECES, HAIR)

    def stand(self, image: Image) -> None:
        """Draw the shirt."""
        self._brush.draw(image, [self._chest])

    def move(self, image: Image, filmed_s: float) -> None:
        """Draw the head as it is now."""
        at = FACE_AT + np.array([SWAY_M * np.sin(2.0 * np.pi * filmed_s / SWAY_S), 0.0, 0.0])
        for part, weights, coat in (self._hair, self._skin):
            solid = Solid(at + HEAD, HEAD_RADII, np.tile(at, (32, 1)))
            self._brush.draw(image, [ShadedBody(solid, (part,), weights, np.zeros_like(HEAD), coat)])
        scale = self._camera.focal_px / float(self._camera.to_camera(at)[2])
        for eye in np.rint(self._pixels(at + EYES)).astype(int).tolist():
            cv2.ellipse(image, eye, (round(0.012 * scale), round(0.006 * scale)), 0, 0, 360, EYE, -1, cv2.LINE_AA)
        left, right = np.rint(self._pixels(at + MOUTH)).astype(int).tolist()
        cv2.line(image, left, right, LIPS, max(1, round(0.009 * scale)), cv2.LINE_AA)

    def _pixels(self, points: Array) -> Array:
        return self._camera.pixels(self._camera.to_camera(points))


def _beside(points: Array) -> Array:
    moved: Array = points * MIRROR + BESIDE
    return moved


def _head_part(pieces: tuple[NDArray[np.intp], ...], colour: Colour) -> tuple[Part, Array, Coat]:
    part = Part("head", pieces)
    weights = np.pad(between((part,), HEAD, HEAD_RADII), ((0, 0), (0, 1)))
    shade = np.tile(reflectance(colour), (len(weights), 1))
    return part, weights, Coat(shade, shade, np.zeros((len(weights), 2)))
