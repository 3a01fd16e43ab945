"""The cell as a MuJoCo model: arm from its URDF, gripper, table, block, target, cameras; the world is base_link."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from common.errors import ModelError
from common.geometry import Array, quaternion_from_rotation
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.meshes import check_meshes, place_meshes
from remote_site.kinematics.model import IMPORT
from remote_site.simulation.config import BLOCK, GRIP, ArmConfig, CellConfig, MarkerConfig
from remote_site.simulation.dressing import PaintedSurface, add_pictured_rectangles, dress
from remote_site.simulation.scenery import (
    PAPER,
    THINGS,
    TOUCHES_ROBOT,
    add_block,
    add_floor,
    add_gripper,
    add_light,
    add_table,
    add_target,
    add_view,
)

MESH_WORDS, INERTIA_WORD = ("decoder", "opening file", "mesh"), "inertia"
MODULE_PX = 24  # of the texture: the renderer averages it as a camera does
PLATE_M = 0.001


def add_marker(spec: mujoco.MjSpec, number: int, config: MarkerConfig) -> None:
    """Put a printed marker with a white module around it on the block, or fix it in the base's frame."""
    body = spec.body(BLOCK) if config.on == BLOCK else spec.worldbody
    name, pose = f"marker_{number}", config.parent_T_marker
    printed = config.family.printed(config.marker, MODULE_PX)
    half = config.size_m / 2 * len(printed) / (len(printed) - 2 * MODULE_PX)
    square = np.array([(-half, -half, 0.0), (half, -half, 0.0), (half, half, 0.0), (-half, half, 0.0)])
    corners = square @ pose[:3, :3].T + pose[:3, 3]
    texels = np.array([(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)])
    add_pictured_rectangles(spec, body, name, np.repeat(printed[:, :, None], 3, axis=2), corners, texels)
    _add_plate(body, pose, half)


def _add_plate(body: mujoco.MjsBody, pose: Array, half: float) -> None:
    """The paper behind the print."""
    *imaginary, real = quaternion_from_rotation(pose[:3, :3])
    centre = pose[:3, 3] - PLATE_M * pose[:3, 2]
    size = [half, half, PLATE_M / 2]
    plate = body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=centre.tolist(), quat=[real, *imaginary], rgba=PAPER
    )
    plate.contype, plate.conaffinity, plate.mass = 0, 0, 0.0


@dataclass(frozen=True, slots=True)
class Cell:
    """A compiled cell; the arm's joints are `arm` in MuJoCo's qpos, qvel and ctrl, its gripper's drive is `grip`.

    `surfaces` are the room's and the table's for the views, where the cell is dressed.
    """

    model: mujoco.MjModel
    joints: tuple[str, ...]
    arm: slice
    grip: int
    start_q: Array
    surfaces: tuple[PaintedSurface, ...] = ()

    def start(self) -> mujoco.MjData:
        """The cell at rest in its start posture, gripper open, block at its start position."""
        data = mujoco.MjData(self.model)
        data.qpos[self.arm] = self.start_q
        mujoco.mj_forward(self.model, data)
        return data


def build_cell(config: CellConfig, robot: RobotConfig, *, dressed: bool = False) -> Cell:
    """Compile the cell around the arm of the robot's URDF; ModelError when URDF and configuration do not fit.

    `dressed`, it has the textures and the room that the views show; it moves the same with and without them.
    """
    spec = _read_arm(robot.urdf)
    joints = tuple(joint.name for joint in spec.joints)
    spec.option.timestep = config.step_ms / 1000.0
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.iterations = 30
    _dress_arm(spec, config.arm, joints)
    tool = _link(spec, robot, robot.tool_frame, "set robot.tool_frame")
    carries = config.gripper.frame
    grip = _link(spec, robot, carries, "set simulation.gripper.frame") if carries else tool
    add_gripper(spec, grip, config.gripper)
    add_light(spec)
    add_floor(spec, config.scene)
    add_table(spec, config.scene)
    add_target(spec, config.scene)
    add_block(spec, config.block, config.scene.table_z_m)
    for view in config.views:
        add_view(tool if view.frame == "tool" else spec.worldbody, view)
    for number, marker in enumerate(config.printed_markers):
        add_marker(spec, number, marker)
    surfaces = dress(spec, config.scene) if dressed else ()
    return _compile(spec, joints, robot, surfaces)


def _link(spec: mujoco.MjSpec, robot: RobotConfig, name: str, cure: str) -> mujoco.MjsBody:
    body = spec.body(name)
    if body is None:
        raise ModelError(f"{robot.urdf}: no link {name!r} to carry the gripper; {cure}")
    return body


def _read_arm(urdf: Path) -> mujoco.MjSpec:
    try:
        robot = ElementTree.parse(urdf).getroot()  # noqa: S314  # the robot model is the site's own file
        for link in robot.findall("link"):
            if link.find("visual") is not None:  # then its collision elements are for clearance, not for contact
                for hull in link.findall("collision"):
                    link.remove(hull)
        meshes = list(robot.iter("mesh"))
        place_meshes(urdf.parent, meshes)
        check_meshes(urdf, meshes)
        extension = ElementTree.SubElement(robot, "mujoco")
        ElementTree.SubElement(extension, "compiler", discardvisual="false", fusestatic="false", strippath="false")
        return mujoco.MjSpec.from_string(ElementTree.tostring(robot, encoding="unicode"))
    except (OSError, ElementTree.ParseError, ValueError) as error:
        raise ModelError(f"{urdf}: MuJoCo cannot read this robot: {error}") from error


def _dress_arm(spec: mujoco.MjSpec, arm: ArmConfig, joints: Sequence[str]) -> None:
    values = (arm.armature_kg_m2, arm.coulomb_n_m, arm.viscous_n_m_s)
    if any(len(value) != len(joints) for value in values):
        raise ModelError(f"the arm has {len(joints)} joints; give simulation.arm as many armatures and frictions")
    for joint, armature, coulomb, viscous in zip(spec.joints, *values, strict=True):
        joint.armature = armature
        joint.frictionloss = coulomb
        joint.damping = [viscous, 0.0, 0.0]
        actuator = spec.add_actuator(name=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=joint.name)
        actuator.set_to_motor()
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = TOUCHES_ROBOT, THINGS


def _compile(
    spec: mujoco.MjSpec, joints: tuple[str, ...], robot: RobotConfig, surfaces: tuple[PaintedSurface, ...]
) -> Cell:
    start_q = robot.start
    if len(start_q) != len(joints):
        raise ModelError(f"robot.start_deg has {len(start_q)} angles for {len(joints)} joints")
    try:
        model = spec.compile()
    except ValueError as error:
        said = " ".join(str(error).split())
        raise ModelError(f"the cell does not compile: {said}; {_cure(said, robot)}") from error
    return Cell(model, joints, slice(0, len(joints)), model.actuator(GRIP).id, start_q, surfaces)


def _cure(said: str, robot: RobotConfig) -> str:
    """Of what MuJoCo says of a cell, which may be the fault of the arm's file."""
    imported = IMPORT.format(urdf=robot.urdf)
    if any(word in said for word in MESH_WORDS):
        return f"give <visual> meshes that are there, as STL or OBJ, or let Farhand choose those: {imported}"
    if INERTIA_WORD in said:
        return f"give every moving link of the URDF an <inertial>, or let Farhand estimate it: {imported}"
    return "correct [simulation]"
