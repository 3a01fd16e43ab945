"""Everything around the arm: room, pedestal, table, target paper, the block of thesis section 5.3, and the cameras."""

import mujoco

from common.geometry import quaternion_from_rotation
from remote_site.simulation.config import BlockConfig, SceneConfig, ViewConfig
from remote_site.simulation.gripper import THINGS, TOUCHES_ROBOT
from remote_site.simulation.views import parent_R_camera

BOX = mujoco.mjtGeom.mjGEOM_BOX
BLOCK = "block"
ROOM_GROUP = 3
TABLE_THICKNESS_M = 0.03
PAPER_THICKNESS_M = 0.0004
MARK_WIDTH_M = 0.006

FLOOR = (0.56, 0.60, 0.64, 1.0)
LINE = (0.49, 0.53, 0.57, 1.0)
WALL = (0.80, 0.84, 0.87, 1.0)
PEDESTAL = (0.30, 0.34, 0.40, 1.0)
WOOD = (0.62, 0.47, 0.33, 1.0)
LEG = (0.36, 0.38, 0.42, 1.0)
PAPER = (0.97, 0.97, 0.95, 1.0)
MARK = (0.85, 0.12, 0.14, 1.0)
FOAM = (0.25, 0.55, 0.80, 1.0)
CASE = (0.12, 0.13, 0.15, 1.0)


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


def add_room(spec: mujoco.MjSpec, scene: SceneConfig) -> None:
    """Floor with a grid of one metre, four walls, and the pedestal under the arm.

    Floor, grid and walls are of `ROOM_GROUP`: they are behind everything else in every view.
    """
    world, z = spec.worldbody, scene.floor_z_m
    floor = _visual_box(world, (2.4, 2.6, 0.05), (0.8, -0.4, z - 0.05), FLOOR)
    floor.contype, floor.conaffinity = THINGS, THINGS
    room = [floor]
    for k in range(-1, 4):
        room.append(_visual_box(world, (0.006, 2.6, 0.003), (k, -0.4, z), LINE))
        room.append(_visual_box(world, (2.4, 0.006, 0.003), (0.8, k - 1.5, z), LINE))
    for x in (-1.65, 3.25):
        room.append(_visual_box(world, (0.05, 2.7, 1.5), (x, -0.4, z + 1.5), WALL))
    for y in (-3.05, 2.25):
        room.append(_visual_box(world, (2.5, 0.05, 1.5), (0.8, y, z + 1.5), WALL))
    for geom in room:
        geom.group = ROOM_GROUP
    half = scene.pedestal_side_m / 2
    _visual_box(world, (half, half, -z / 2), (0, 0, z / 2), PEDESTAL)


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
    body = spec.worldbody.add_body(name=BLOCK, pos=[*block.centre_xy_m, table_z_m + height / 2])
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
    x, y, z, w = quaternion_from_rotation(parent_R_camera(view))
    if view.frame == "tool":
        _add_mount(body, view)
    body.add_camera(name=view.name, pos=list(view.position_m), quat=[w, x, y, z], fovy=view.fovy_deg)


def _add_mount(tool: mujoco.MjsBody, view: ViewConfig) -> None:
    """The camera's case and its bracket, too near for the camera to see, or out of its view."""
    x, y, z = view.position_m
    _visual_box(tool, (0.018, 0.022, 0.014), (x, y, z - 0.015), CASE)
    _visual_box(tool, (abs(x) / 2, 0.008, 0.004), (x / 2, y, z - 0.025), CASE)


def _visual_box(
    body: mujoco.MjsBody,
    half_size: tuple[float, float, float],
    centre: tuple[float, float, float],
    rgba: tuple[float, float, float, float],
    name: str = "",
) -> mujoco.MjsGeom:
    return body.add_geom(name=name, type=BOX, size=half_size, pos=centre, rgba=rgba, contype=0, conaffinity=0, mass=0)
