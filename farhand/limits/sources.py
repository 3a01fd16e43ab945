"""Where the limits of an arm's file come from: its maker, or `farhand arm import`, which marks what it assumed."""

from collections.abc import Mapping

import numpy as np

from common.geometry import Array
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.model import ASSUMED, GIVEN, ArmModel

FILE = "the arm's file"
BY_IMPORT = {ASSUMED: "assumed by farhand arm import", GIVEN: "given to farhand arm import"}


def file_source(model: ArmModel, key: str, values: Array) -> str:
    """The source of the file's values (n,) of one attribute of its limits."""
    parts = []
    others = list(model.joint_names)
    for mark, words in BY_IMPORT.items():
        names = _unchanged(model, model.marked(mark, key), values)
        others = [name for name in others if name not in names]
        if names:
            parts.append(words if len(names) == len(model.joint_names) else f"{words} for {', '.join(names)}")
    if not parts:
        return FILE
    return "; ".join(parts) + (f"; else {FILE}" if others else "")


def assumed_in_configuration(model: ArmModel, key: str, values: Array) -> str:
    """What follows the key of values (n,) that the import assumed in the configuration; nothing where it did not."""
    names = _unchanged(model, model.marked(ASSUMED, key), values)
    if not names:
        return ""
    return f", {BY_IMPORT[ASSUMED]}" + ("" if len(names) == len(model.joint_names) else f" for {', '.join(names)}")


def of_another_arm(robot: RobotConfig) -> str:
    """What follows the key of an acceleration that no configuration gives, where the arm is not the A465."""
    default = RobotConfig()
    is_foreign = robot.model != default.model and robot.acceleration_rad_s2 == default.acceleration_rad_s2
    return ", by default the A465's: give your own" if is_foreign else ""


def _unchanged(model: ArmModel, marked: Mapping[str, float], values: Array) -> list[str]:
    """The joints whose value is still the one that it is marked with."""
    stated = zip(model.joint_names, values.tolist(), strict=True)
    return [name for name, value in stated if name in marked and np.isclose(value, marked[name])]
