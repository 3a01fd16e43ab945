"""An upright arm with parallel shoulder and elbow and a spherical wrist: lengths read from a model and verified."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import pinocchio as pin

from common.errors import ModelError
from common.geometry import Array, inverse, transform
from remote_site.kinematics.model import ArmModel

EXACT = 1e-6  # m, and of unit axes
PATTERN = "zyyzyz"  # the axis of each joint at the zero posture, in the base frame
CURE = "the closed form needs axes z y y z y z that meet the base's z axis at the zero posture"


@dataclass(frozen=True, slots=True)
class UprightGeometry:
    """Lengths in m; `signs` turn the joints' positions into angles positive about +z and +y; `wrist_T_tcp` (4 x 4).

    At the zero posture the wrist frame has the axes of the base and its origin in the wrist centre.
    """

    shoulder_height: float
    upper_arm: float
    forearm: float
    signs: tuple[float, ...]
    wrist_T_tcp: Array

    @classmethod
    def from_model(cls, model: ArmModel) -> Self:
        """Read and verify the geometry; ModelError says where the arm is of another kind."""
        if len(model.joint_names) != len(PATTERN):
            raise ModelError(f"the arm has {len(model.joint_names)} joints; {CURE}")
        origins, axes = _zero_posture(model.pin_model)
        signs = tuple(_sign(name, axes[i], PATTERN[i]) for i, name in enumerate(model.joint_names))
        for i, name in enumerate(model.joint_names):
            beside = origins[i, :2] if PATTERN[i] == "z" else origins[i, :1]
            if np.abs(beside).max() > EXACT:
                raise ModelError(f"{name} lies beside the base's z axis; {CURE}")
        shoulder, elbow, wrist = origins[1, 2], origins[2, 2], origins[4, 2]
        if not shoulder < elbow < wrist:
            raise ModelError(f"shoulder, elbow and wrist do not stand above each other; {CURE}")
        base_T_wrist = transform(np.eye(3), np.array([0.0, 0.0, wrist]))
        wrist_T_tcp = inverse(base_T_wrist) @ model.forward(np.zeros(len(PATTERN)))
        return cls(float(shoulder), float(elbow - shoulder), float(wrist - elbow), signs, wrist_T_tcp)


def _zero_posture(model: pin.Model) -> tuple[Array, Array]:
    """Origins and unit axes (n, 3) of the joints in the base frame."""
    data = model.createData()
    jacobian = pin.computeJointJacobians(model, data, np.zeros(model.nq))
    origins = np.array([data.oMi[i].translation for i in range(1, model.njoints)])
    return origins, np.array(jacobian[3:].T)


def _sign(name: str, axis: Array, letter: str) -> float:
    along = axis["xyz".index(letter)]
    if abs(abs(along) - 1) > EXACT:
        raise ModelError(f"{name} does not turn about the base's {letter} axis at the zero posture; {CURE}")
    return 1.0 if along > 0 else -1.0
