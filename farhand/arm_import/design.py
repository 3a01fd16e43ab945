"""From an arm in capsules to the numbers of its configuration: shapes that fit, start posture, box, cell; pure."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, transform
from farhand.arm_import.choices.cell import CellScene, JointNumbers, fitting_speed, joint_numbers, margins, scene, table
from farhand.arm_import.choices.posture import Direction, Start, choose_start
from farhand.arm_import.choices.reaching import Reaching, reach_of, touching
from farhand.arm_import.choices.tool import GRIPPER_M
from farhand.arm_import.prepared import PreparedArm
from farhand.terminal import ShowProgress
from remote_site.kinematics.config import GRIPPER, CapsuleConfig, RobotConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.safety.collision import CollisionModel
from remote_site.safety.config import CollisionConfig, FixtureConfig

Prepare = Callable[[Collection[str], bool], PreparedArm]  # links as hulls; whether the tool's frame is turned
Load = Callable[[PreparedArm], "LoadedArm"]
OFTEN, FREED = 0.2, 0.1  # of all postures: capsules that touch so often give way to hulls that free so many
NEARLY_ALWAYS = 0.95  # of all postures: those bodies are built into each other


@dataclass(frozen=True, slots=True, eq=False)
class LoadedArm:
    """An arm as the remote site loads it, with what measures its distances in a cell."""

    model: ArmModel
    collision: Callable[[CollisionConfig], CollisionModel]


@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """An arm that can be written, and every number of its configuration. `hulls` are links without capsules."""

    prepared: PreparedArm
    hulls: tuple[str, ...]
    reach_m: float
    limits: JointLimits
    speed: float
    joints: JointNumbers
    fixtures: tuple[FixtureConfig, ...]
    ignored: tuple[tuple[str, str], ...]
    margins: tuple[float, float]
    start: Start
    tool_m: Array
    scene: CellScene
    jerk_given: bool

    @property
    def without_jerk(self) -> tuple[str, ...]:
        """The joints whose file states no jerk."""
        return tuple(joint.name for joint in self.prepared.arm.joints if joint.limit.jerk is None)

    @property
    def jerk(self) -> float:
        """The jerk that counts for them, rad/s³."""
        written = {joint.name: joint.limit.jerk for joint in self.prepared.joints}
        return min((written[name] or 0.0 for name in self.without_jerk), default=0.0)


def tool_T_tcp() -> Array:
    """The tool centre point in the frame that carries the tool."""
    return transform(np.eye(3), np.array([0.0, 0.0, GRIPPER_M]))


def tool_capsules(prepared: PreparedArm) -> tuple[CapsuleConfig, ...]:
    """The tool's own, or the simulated gripper's on a bare flange."""
    if not prepared.tool.own:
        return GRIPPER
    return tuple(
        CapsuleConfig(link=link, start_m=_row(c.start), end_m=_row(c.end), radius_m=round(c.radius + 6e-5, 4))
        for link, c in prepared.tool.capsules
    )


def _row(point: Array) -> tuple[float, float, float]:
    x, y, z = (round(value, 5) + 0.0 for value in point.tolist())
    return x, y, z


def design(prepare: Prepare, load: Load, points: Direction | None, show: ShowProgress, *, jerk_given: bool) -> Design:
    """Choose everything; ModelError where there is no start posture."""
    capsules = prepare((), False)
    hulls = _better_as_hulls(_touching(capsules, load), lambda: _touching(prepare(_meshed(capsules), False), load))
    hulls = tuple(name for name in hulls if name in _meshed(capsules))
    prepared = prepare(hulls, False) if hulls else capsules
    arm, numbers = load(prepared), joint_numbers(prepared.joints)
    robot = RobotConfig(acceleration_rad_s2=numbers.acceleration)
    limits = JointLimits.from_model(arm.model, robot)
    speed = fitting_speed(limits)
    fixtures, reach_m = _table(arm, limits)
    near = touching(Reaching(arm.model, limits, arm.collision(CollisionConfig(fixtures=fixtures))))
    ignored = tuple(names for names, often in near.items() if often >= NEARLY_ALWAYS)
    collision = arm.collision(CollisionConfig(fixtures=fixtures, ignored_pairs=ignored))
    reaching = Reaching(arm.model, limits, collision)
    start = choose_start(reaching, reach_m, points, show)
    tool_m = arm.model.position(start.q)
    return Design(
        prepare(hulls, True) if start.turned else prepared,
        hulls,
        reach_m,
        limits,
        speed,
        numbers,
        fixtures,
        ignored,
        margins(start.box.near_m),
        start,
        tool_m,
        scene(tool_m, reach_m, start.scale, points_down=start.points == "down"),
        jerk_given,
    )


def _meshed(prepared: PreparedArm) -> list[str]:
    """The links that have collision meshes."""
    return [link.name for link in prepared.arm.description.links.values() if prepared.has_meshes(link.name)]


def _table(arm: LoadedArm, limits: JointLimits) -> tuple[tuple[FixtureConfig, ...], float]:
    """The table, and how far the tool reaches."""
    reach_m = reach_of(Reaching(arm.model, limits, arm.collision(CollisionConfig(fixtures=()))))
    return (table(reach_m),), reach_m


def _touching(prepared: PreparedArm, load: Load) -> Mapping[tuple[str, str], float]:
    arm = load(prepared)
    limits = JointLimits.from_model(
        arm.model, RobotConfig(acceleration_rad_s2=joint_numbers(prepared.joints).acceleration)
    )
    fixtures, _ = _table(arm, limits)
    return touching(Reaching(arm.model, limits, arm.collision(CollisionConfig(fixtures=fixtures))))


def _better_as_hulls(
    as_capsules: Mapping[tuple[str, str], float], as_hulls: Callable[[], Mapping[tuple[str, str], float]]
) -> tuple[str, ...]:
    """The links whose capsules touch others in many postures in which their hulls do not."""
    often = [names for names, fraction in as_capsules.items() if fraction >= OFTEN]
    if not often:
        return ()
    hulls = as_hulls()
    freed = [names for names in often if hulls.get(names, 0.0) <= as_capsules[names] - FREED]
    return tuple(dict.fromkeys(name for names in freed for name in names))
