"""Postures that a human arm has: elbow, forearm's turn, wrist, and every finger by itself."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array, rotation_from_vector
from lab.films.arm.arm_mesh import ArmMesh
from lab.films.arm.posing import PosedArm
from lab.films.arm.postures import PostureName, posture_angles
from local_site.simulation.body import BodyPose

NAMED: tuple[PostureName, ...] = ("u_shape", "open", "fist", "pointing", "flat")
NAMED_SHARE = 0.4
# Degrees from the mesh at rest: a straight finger has (-20, -16, -8), a fist (60, 82, 48).
STRAIGHT, CURLED = np.array([-26.0, -16.0, -8.0]), np.array([64.0, 86.0, 50.0])
SPREAD_DEG = np.array([10.0, 5.0, 6.0, 14.0])  # index to little
THUMB_LOW, THUMB_HIGH = np.array([-8.0, -14.0, -14.0, -22.0]), np.array([44.0, 32.0, 48.0, 16.0])
ELBOW_DEG = (3.0, 148.0)  # 0 is straight
PRONATION_DEG = (-95.0, 95.0)
FLEXION_DEG, DEVIATION_DEG = (-72.0, 78.0), (-32.0, 42.0)


@dataclass(frozen=True, slots=True)
class ArmPosture:
    """A posture: the skeleton with the elbow at (0, 0, 0), forearm along x, in m; the fingers' angles (5, 4) in rad."""

    pose: BodyPose
    angles: Array


def random_posture(random: np.random.Generator, mesh: ArmMesh, arm: PosedArm) -> ArmPosture:
    """Draw a posture of a body's arm; the wrist bends less while it also bends sideways, as wrists do."""
    elbow = np.zeros(3)
    bend = np.radians(random.uniform(*ELBOW_DEG))
    shoulder = mesh.upper_arm_m * np.array([-np.cos(bend), np.sin(bend), 0.0])
    wrist = np.array([mesh.forearm_m, 0.0, 0.0])
    neutral = arm.neutral_hand(BodyPose(shoulder, elbow, wrist, np.eye(3), 0.0))
    turned = rotation_from_vector(np.radians(random.uniform(*PRONATION_DEG)) * np.array([1.0, 0.0, 0.0])) @ neutral
    hand = turned @ _bent_wrist(random)
    return ArmPosture(BodyPose(shoulder, elbow, wrist, hand, 0.0), random_fingers(random))


def random_fingers(random: np.random.Generator) -> Array:
    """Draw the fingers' angles (5, 4) in rad: between named postures, or each finger by itself."""
    if random.random() < NAMED_SHARE:
        one, other = (posture_angles(NAMED[k]) for k in random.integers(len(NAMED), size=2))
        share = random.choice([0.0, random.random()])
        angles = (1.0 - share) * one + share * other
        return np.asarray(angles + np.radians(6.0) * random.standard_normal((5, 4)) * (1.0, 1.0, 0.6, 0.5))
    return np.radians(np.vstack([_thumb(random), _fingers(random)]))


def _bent_wrist(random: np.random.Generator) -> Array:
    """The hand's turn (3, 3) against the forearm: half of them nearly straight, the others anywhere a wrist goes."""
    reach = 0.35 if random.random() < 0.4 else 1.0
    flexion, deviation = reach * random.uniform(*FLEXION_DEG), reach * random.uniform(*DEVIATION_DEG)
    deviation *= 1.0 - 0.6 * abs(flexion) / max(np.abs(FLEXION_DEG))
    bend = rotation_from_vector(np.radians(flexion) * np.array([0.0, 1.0, 0.0]))
    return bend @ rotation_from_vector(np.radians(deviation) * np.array([0.0, 0.0, 1.0]))


def _fingers(random: np.random.Generator) -> Array:
    """Four fingers (4, 4) in degrees: alike, or each straight, curled or between by itself."""
    curl = np.clip(random.beta(0.5, 0.5, 4), 0.0, 1.0)
    if random.random() < 0.35:
        curl = np.clip(random.random() + 0.12 * random.standard_normal(4), 0.0, 1.0)
    joints = np.clip(curl[:, None] + 0.14 * random.standard_normal((4, 3)), 0.0, 1.0)
    joints[:, 2] = 0.3 * joints[:, 2] + 0.7 * joints[:, 1]  # a tendon moves the last joint with the middle one
    flexions = STRAIGHT + joints * (CURLED - STRAIGHT)
    spread = random.uniform(-1.0, 1.0) * np.array([1.0, 0.2, -0.5, -1.0]) * SPREAD_DEG
    spread = (1.0 - joints[:, 0]) * spread + 2.0 * random.standard_normal(4)  # a bent finger cannot be spread
    return np.column_stack([flexions, spread])


def _thumb(random: np.random.Generator) -> Array:
    share = random.beta(0.7, 0.7, 4)
    share[2] = 0.5 * (share[1] + share[2])
    return np.asarray(THUMB_LOW + share * (THUMB_HIGH - THUMB_LOW))
