"""The box of the tool against what the arm can reach: a side beyond it holds nothing back; pure."""

from collections.abc import Iterator

from common.errors import ConfigError
from remote_site.kinematics.model import ArmModel
from remote_site.safety.config import SafetyConfig

AXES = ("x", "y", "z")


def check_box(safety: SafetyConfig, model: ArmModel) -> None:
    """ConfigError where the box is longer along an axis than all that the tool can reach."""
    mistakes = [
        f"safety.workspace_min_m and _max_m: the box is {high - low:g} m along {axis}, and the tool reaches over "
        f"{most - least:.2f} m only, from {least:.2f} to {most:.2f} m"
        for axis, (low, high), (least, most) in _extents(safety, model)
        if high - low > most - least
    ]
    if mistakes:
        raise ConfigError("\n".join(mistakes))


def idle_sides(safety: SafetyConfig, model: ArmModel) -> list[str]:
    """The sides of the box that the tool cannot come to, each with how far it reaches."""
    sides = []
    for axis, (low, high), (least, most) in _extents(safety, model):
        sides += [f"{axis} from {low:g} m (the tool reaches {least:.2f} m)"] if low < least else []
        sides += [f"{axis} up to {high:g} m (the tool reaches {most:.2f} m)"] if high > most else []
    return sides


def _extents(safety: SafetyConfig, model: ArmModel) -> Iterator[tuple[str, tuple[float, float], tuple[float, float]]]:
    """Of each axis the box's ends and the reach's, m."""
    reach = zip(*(corner.tolist() for corner in model.reach), strict=True)
    return zip(AXES, zip(safety.workspace_min_m, safety.workspace_max_m, strict=True), reach, strict=True)
