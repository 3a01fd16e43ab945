"""Everything on and around the arm: gripper, floor, table, target paper, block of thesis section 5.3, and cameras."""

import math

import mujoco

from common.geometry import quaternion_from_rotation
from remote_site.simulation.config import (
    BLOCK,
    FINGERS,
    GRIP,
    GRIPPER_BODY,
    BlockConfig,
    GripperConfig,
    SceneConfig,
    ViewConfig,
)
from remote_site.simulation.views import parent_R_camera

BOX = mujoco.mjtGeom.mjGEOM_BOX
THINGS = 1
TOUCHES_ROBOT = 2
ROOM_GROUP = 3
TABLE_MASK = 254  # the alpha, of 255, by which a view's renderer knows where the table is to be seen
TABLE_THICKNESS_M = 0.03
PAPER_THICKNESS_M = 0.0004
MARK_WIDTH_M = 0.006
STIFFNESS_N_M = 4000.0
DAMPING_N_S_M = 60.0
FINGER_THICKNESS_M = 0.008
FINGER_HEIGHT_M = 0.022

FLOOR = (0.56, 0.60, 0.64, 1.0)
PEDESTAL = (0.30, 0.34, 0.40, 1.0)
WOOD = (0.62, 0.47, 0.33, TABLE_MASK / 255 + 0.0005)
LEG = (0.36, 0.38, 0.42, 1.0)
PAPER = (0.97, 0.97, 0.95, 1.0)
MARK = (0.85, 0.12, 0.14, 1.0)
FOAM = (0.25, 0.55, 0.80, 1.0)
CASE = (0.12, 0.13, 0.15, 1.0)
DARK = (0.17, 0.19, 0.23, 1.0)
STEEL = (0.62, 0.65, 0.68, 1.0)
PAD = (0.95, 0.55, 0.15, 1.0)


def add_gripper(spec: mujoco.MjSpec, tool: mujoco.MjsBody, config: GripperConfig) -> None:
    """Mount the gripper on the tool frame, its fingers pointing along the tool's z and closing along y.

    The opening (m) is the tendon `grip`; its drive holds a commanded opening with at most `force_limit_n`.
    """
    body = tool.add_body(name=GRIPPER_BODY)
    _add_housing(body, config)
    tendon = spec.add_tendon(name=GRIP)
    for side, name in zip((1.0, -1.0), FINGERS, strict=True):
        _add_finger(body, name, side, config)
        tendon.wrap_joint(name, 1.0)
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1=FINGERS[0],
        name2=FINGERS[1],
        data=[0, 1, *[0] * 10],
        solref=[0.004, 1.0],
    )
    drive = spec.add_actuator(name=GRIP, trntype=mujoco.mjtTrn.mjTRN_TENDON, target=GRIP)
    drive.set_to_position(kp=STIFFNESS_N_M, kv=DAMPING_N_S_M)
    drive.forcelimited = True
    drive.forcerange = [-config.force_limit_n, config.force_limit_n]


def _add_housing(body: mujoco.MjsBody, config: GripperConfig) -> None:
    neck, block = 0.4 * config.body_length_m, 0.6 * config.body_length_m
    half = {"contype": TOUCHES_ROBOT, "conaffinity": THINGS}
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[0.028, neck / 2, 0],
        pos=[0, 0, neck / 2],
        rgba=STEEL,
        mass=0.3 * config.body_mass_kg,
        **half,
    )
    body.add_geom(
        type=BOX,
        size=[0.026, 0.052, block / 2],
        pos=[0, 0, neck + block / 2],
        rgba=DARK,
        mass=0.7 * config.body_mass_kg,
        **half,
    )


def _add_finger(body: mujoco.MjsBody, name: str, side: float, config: GripperConfig) -> None:
    half_opening = config.max_opening_m / 2.0
    finger = body.add_body(name=name, pos=[0, 0, config.body_length_m])
    finger.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[0, side, 0],
        range=[0.0, half_opening],
        ref=half_opening,
        damping=[5.0, 0, 0],
    )
    finger.add_geom(
        name=name,
        type=BOX,
        size=[FINGER_HEIGHT_M / 2, FINGER_THICKNESS_M / 2, config.finger_length_m / 2],
        pos=[0, side * (half_opening + FINGER_THICKNESS_M / 2), config.finger_length_m / 2],
        rgba=PAD,
        mass=config.finger_mass_kg,
        friction=[config.friction, 0.02, 0.001],
        condim=4,
        solref=[0.004, 1.0],
        solimp=[0.97, 0.995, 0.001, 0.5, 2],
        priority=1,
        contype=TOUCHES_ROBOT,
        conaffinity=THINGS,
    )


def add_light(spec: mujoco.MjSpec) -> None:
    """Light from above and from the cameras, and shapes no finer than a software renderer draws quickly."""
    visual = spec.visual
    visual.headlight.ambient, visual.headlight.diffuse = [0.35, 0.35, 0.36], [0.25, 0.25, 0.25]
    visual.headlight.specular = [0.0, 0.0, 0.0]
    visual.map.znear, spec.stat.extent = 0.02, 2.0
    visual.quality.numslices, visual.quality.numstacks, visual.quality.numquads = 20, 2, 1
    visual.quality.shadowsize = visual.quality.offsamples = 0
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[1.5, -1, 3],
        dir=[-0.5, 0.45, -0.85],
        diffuse=[0.55, 0.54, 0.52],
        specular=[0.05, 0.05, 0.05],
        castshadow=False,
    )


def add_floor(spec: mujoco.MjSpec, scene: SceneConfig) -> None:
    """The floor, and the pedestal under the arm."""
    z, half = scene.floor_z_m, scene.pedestal_side_m / 2
    floor = _visual_box(spec.worldbody, (2.4, 2.6, 0.05), (0.8, -0.4, z - 0.05), FLOOR, "floor")
    floor.contype, floor.conaffinity = THINGS, THINGS
    _visual_box(spec.worldbody, (half, half, -z / 2), (0, 0, z / 2), PEDESTAL)


def add_table(spec: mujoco.MjSpec, scene: SceneConfig) -> None:
    """The table, its top at `table_z_m`."""
    (x, y), (length, width), top = scene.table_centre_xy_m, scene.table_size_xy_m, scene.table_z_m
    half = TABLE_THICKNESS_M / 2
    spec.worldbody.add_geom(
        name="table",
        type=BOX,
        size=[length / 2, width / 2, half],
        pos=[x, y, top - half],
        rgba=WOOD,
        contype=THINGS,
        conaffinity=THINGS | TOUCHES_ROBOT,
        friction=[0.6, 0.005, 0.0001],
    )
    leg = (top - TABLE_THICKNESS_M - scene.floor_z_m) / 2
    for side in (-1, 1):
        for end in (-1, 1):
            centre = (x + end * (length / 2 - 0.04), y + side * (width / 2 - 0.04), scene.floor_z_m + leg)
            _visual_box(spec.worldbody, (0.02, 0.02, leg), centre, LEG)


def add_target(spec: mujoco.MjSpec, scene: SceneConfig) -> None:
    """The square paper on the table, its corner (+x, -y) marked: there the block's red corner belongs (figure 5.7)."""
    (x, y), side, half = scene.target_corner_xy_m, scene.target_side_m, PAPER_THICKNESS_M / 2
    z, mark = scene.table_z_m + half, MARK_WIDTH_M / 2
    _visual_box(spec.worldbody, (side / 2, side / 2, half), (x - side / 2, y + side / 2, z), PAPER, "target")
    _visual_box(spec.worldbody, (side / 4, mark, half), (x - side / 4, y - mark, z + half), MARK)
    _visual_box(spec.worldbody, (mark, side / 4 + mark, half), (x + mark, y + side / 4 - mark, z + half), MARK)


def add_block(spec: mujoco.MjSpec, block: BlockConfig, table_z_m: float) -> None:
    """The foam block, free to move, standing on the table; its corner (+x, -y) carries a red stripe."""
    depth, thickness, height = block.size_m
    half_yaw = math.radians(block.yaw_deg) / 2
    turned = [math.cos(half_yaw), 0.0, 0.0, math.sin(half_yaw)]
    body = spec.worldbody.add_body(name=BLOCK, pos=[*block.centre_xy_m, table_z_m + height / 2], quat=turned)
    body.add_freejoint(name=BLOCK)
    body.add_geom(
        name=BLOCK,
        type=BOX,
        size=[depth / 2, thickness / 2, height / 2],
        rgba=FOAM,
        mass=block.mass_kg,
        friction=[block.friction, 0.02, 0.001],
        condim=4,
        contype=THINGS,
        conaffinity=THINGS | TOUCHES_ROBOT,
    )
    stripe = MARK_WIDTH_M / 2
    corner = (depth / 2 - stripe + 0.0005, -thickness / 2 + stripe - 0.0005, 0.0)
    _visual_box(body, (stripe, stripe, height / 2), corner, MARK)


def add_view(body: mujoco.MjsBody, view: ViewConfig) -> None:
    """Add a camera to the world or to the tool; MuJoCo's cameras look along -z with y up."""
    *imaginary, real = quaternion_from_rotation(parent_R_camera(view))
    if view.frame == "tool":  # case and bracket of the camera, too near for it to see, or out of its view
        x, y, z = view.position_m
        _visual_box(body, (0.018, 0.022, 0.014), (x, y, z - 0.015), CASE)
        _visual_box(body, (abs(x) / 2, 0.008, 0.004), (x / 2, y, z - 0.025), CASE)
    body.add_camera(name=view.name, pos=list(view.position_m), quat=[real, *imaginary], fovy=view.fovy_deg)


def _visual_box(
    body: mujoco.MjsBody,
    half_size: tuple[float, float, float],
    centre: tuple[float, float, float],
    rgba: tuple[float, float, float, float],
    name: str = "",
) -> mujoco.MjsGeom:
    return body.add_geom(name=name, type=BOX, size=half_size, pos=centre, rgba=rgba, contype=0, conaffinity=0, mass=0)
