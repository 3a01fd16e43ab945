"""Parts that a configuration leaves unguarded, to be said: fixtures, tool, links, pairs, sides of the box; pure."""

from collections.abc import Sequence

from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.model import ArmModel
from remote_site.safety.collision_geometry import links_without_shape, read_shapes
from remote_site.safety.config import SafetyConfig
from remote_site.safety.workspace_box import idle_sides

ALWAYS = "people, cables, and whatever is no box in safety.collision.fixtures"


def unguarded(robot: RobotConfig, safety: SafetyConfig, model: ArmModel) -> tuple[str, ...]:
    """Each part that this configuration could guard and does not; raises as `read_shapes` does."""
    collision, parts = safety.collision, []
    if not collision.fixtures:
        parts.append("the cell (safety.collision.fixtures is empty)")
    if not robot.capsules:
        parts.append("the tool (robot.capsules is empty)")
    bare = links_without_shape(model.pin_model, read_shapes(robot.urdf, model, robot.capsules, collision))
    if bare:
        parts.append(f"links without a shape: {', '.join(bare)}")
    parts += [f"{one} against {other} (safety.collision.ignored_pairs)" for one, other in collision.ignored_pairs]
    parts += [f"the box's side {side}" for side in idle_sides(safety, model)]
    return tuple(parts)


def in_one_line(parts: Sequence[str]) -> str:
    """These parts, and what no configuration guards."""
    return "; ".join([*parts, ALWAYS])
