"""Masses and inertias that a simulation can use: those of the file, mended or estimated from the shapes; pure."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from farhand.arm_import.description.elements import Inertial
from farhand.arm_import.shapes.capsule import Capsule

DENSITY_KG_M3 = 1500.0  # of a link by the volume of its capsules: between a UR5's and an iiwa's
LEAST_MASS_KG, LEAST_INERTIA_KG_M2 = 1e-4, 1e-7
EMPTY = Inertial(0.1, np.zeros(3), 1e-4 * np.eye(3))


def usable(inertial: Inertial | None) -> bool:
    """Whether mass and inertia are those of a body: positive, no moment above the sum of the two others."""
    if inertial is None or not inertial.mass_kg >= LEAST_MASS_KG or not np.isfinite(inertial.inertia_kg_m2).all():
        return False
    moments = np.linalg.eigvalsh(inertial.inertia_kg_m2)
    return bool(moments[0] >= LEAST_INERTIA_KG_M2 and moments[0] + moments[1] >= moments[2] * (1 - 1e-6))


def estimated(capsules: Sequence[Capsule]) -> Inertial:
    """Of a link whose file states none: as if its capsules were solid; small where it has none."""
    if not capsules:
        return EMPTY
    masses = [DENSITY_KG_M3 * capsule.volume for capsule in capsules]
    middles = [(capsule.start + capsule.end) / 2 for capsule in capsules]
    centre = np.average(middles, axis=0, weights=masses)
    about = [_rod(c, m) + _moved(m, at - centre) for c, m, at in zip(capsules, masses, middles, strict=True)]
    return Inertial(float(sum(masses)), centre, np.sum(about, axis=0))


def mended(inertial: Inertial) -> Inertial | None:
    """With the mean of its moments about all axes where the file's are those of no body; None without a mass."""
    mean = float(np.abs(np.linalg.eigvalsh(inertial.inertia_kg_m2)).mean())
    if inertial.mass_kg < LEAST_MASS_KG or not mean >= LEAST_INERTIA_KG_M2:
        return None
    return Inertial(inertial.mass_kg, inertial.centre_m, mean * np.eye(3))


def _rod(capsule: Capsule, mass: float) -> Array:
    """The inertia (3 x 3) of a solid cylinder of the capsule's length and radius about its middle."""
    along = capsule.end - capsule.start
    length = float(np.sqrt(along @ along)) + capsule.radius
    axis = along / np.sqrt(along @ along) if along.any() else np.eye(3)[2]
    lengthways, across = mass * capsule.radius**2 / 2, mass * (3 * capsule.radius**2 + length**2) / 12
    rod: Array = across * np.eye(3) + (lengthways - across) * np.outer(axis, axis)
    return rod


def _moved(mass: float, by: Array) -> Array:
    moved: Array = mass * (float(by @ by) * np.eye(3) - np.outer(by, by))
    return moved
