"""The elbow of seven axes: which joints carry it, and how gently it starts, turns back and stops."""

from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig, SolverConfig
from remote_site.kinematics.swivel import ACCELERATION, SPEED_FRACTION, Swivel
from tests.remote_site.arms_followed import SEVEN_AXES
from tests.remote_site.remote_loop import arm

DT, FAST = 0.004, 100.0
FR3 = RemoteConfig(robot=RobotConfig(model="fr3", tool_frame="fr3_hand", acceleration_rad_s2=(10.0,)))


class Elbow:
    """A swivel of an arm that stands, and what its null space is."""

    def __init__(self, config: RemoteConfig, q: np.ndarray, fastest: float, **solver: Any) -> None:
        model, _ = arm(config)
        found = Swivel.of(model, SolverConfig(**solver))
        assert found is not None
        self._swivel, self._fastest = found, np.full(7, fastest)
        self._data = model.pin_model.createData()
        self._jacobian = pin.computeJointJacobians(model.pin_model, self._data, q)
        self.free = np.linalg.svd(model.jacobian(q))[2][-1]

    def rate(self, turned: float) -> float:
        """Along the null space, after the operator's elbow, 0.2 m beside the line, has turned by an angle in rad."""
        elbow = 0.2 * np.array([0.0, np.cos(turned), np.sin(turned)])
        return self._swivel.rate(self._data, self._jacobian, self.free, elbow, self._fastest, DT)


def posture(config: RemoteConfig) -> np.ndarray:
    return np.array(config.robot.start) if config is SEVEN_AXES else np.radians([10.0, -40, 15, -120, 20, 90, 30])


@pytest.mark.parametrize(("config", "name"), [(SEVEN_AXES, "a{}"), (FR3, "fr3_joint{}")], ids=["seven axes", "fr3"])
def test_by_default_the_second_fourth_and_sixth_joint_carry_shoulder_elbow_and_wrist(
    config: RemoteConfig, name: str
) -> None:
    q = posture(config)
    joints = [tuple(map(name.format, joints)) for joints in ((2, 4, 6), (2, 4, 7))]
    elbows = Elbow(config, q, FAST), *(Elbow(config, q, FAST, swivel_joints=names) for names in joints)
    default, named, other = ([elbow.rate(turned) for turned in (0.0, *[0.3] * 60)] for elbow in elbows)
    assert default == named
    assert max(np.abs(default)) > 0.1
    assert default != other  # the seventh lies beyond the wrist, or beside it


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_elbow_gains_and_loses_speed_gently_to_both_sides(side: float) -> None:
    elbow = Elbow(SEVEN_AXES, posture(SEVEN_AXES), FAST)
    rates = np.array([elbow.rate(turned) for turned in (0.0, *[side] * 100, *[-side] * 200, *[0.0] * 100)])
    step = abs(rates[1])  # from rest: as much of the elbow's speed as its acceleration gives in a tick
    assert step > 0.0
    assert np.abs(np.diff(rates)).max() <= step * (1 + 1e-9)
    assert max(rates) == pytest.approx(-min(rates))
    assert max(rates) == pytest.approx(step * SolverConfig().swivel_speed_rad_s / (ACCELERATION * DT))


def test_the_elbow_leaves_the_tool_a_part_of_every_joints_speed() -> None:
    elbow = Elbow(SEVEN_AXES, posture(SEVEN_AXES), 0.5)
    rates = [elbow.rate(turned) for turned in (0.0, *[1.0] * 100)]
    assert np.abs(elbow.free * max(np.abs(rates))).max() == pytest.approx(SPEED_FRACTION * 0.5)
