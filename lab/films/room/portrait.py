"""A portrait of a hand, for posters: the open right hand of the mesh before a pale ground."""

import numpy as np

from lab.films.arm.arm_mesh import MESH, load_arm_mesh
from lab.films.arm.motions import WRIST, ArmMotion
from lab.films.arm.posing import PosedArm
from lab.films.arm.postures import posture_angles
from lab.films.arm.skin import arm_albedo
from lab.films.picture.light import Lighting, lit
from lab.films.picture.rendering import rendered
from common.cameras.camera import Image
from local_site.calibration.physical_camera import Lens, PhysicalCamera

DISTANCE_M = 1.1
SIZE = (620, 500)
GROUND = (214, 222, 226)
BESIDE = np.array([-0.10, 0.0, 0.03])  # from the wrist to the middle of the portrait, m


def hand_portrait() -> Image:
    """The picture (H, W, 3), BGR."""
    mesh = load_arm_mesh(MESH, "average")
    pose = ArmMotion("hold", mesh.upper_arm_m, mesh.forearm_m, np.radians(80.0), seed=0).pose(0.0)
    vertices = PosedArm(mesh).vertices(pose, posture_angles("open"))
    window = np.array([-0.5, -0.7, 0.5])
    lighting = Lighting(window / np.linalg.norm(window), np.array([0.6, -0.8, 0.0]))
    colours = lit(vertices, mesh.triangles, arm_albedo(mesh, "light", (60, 60, 80), seed=0), lighting)
    along_y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    stand = WRIST + BESIDE - np.array([0.0, DISTANCE_M, 0.0])
    camera = PhysicalCamera(Lens(1300.0, 1300.0, SIZE[0] / 2, SIZE[1] / 2), along_y, -along_y @ stand)
    picture = np.full((SIZE[1], SIZE[0], 3), GROUND, np.float32)
    layer = rendered(camera, SIZE, [vertices], mesh.triangles, colours)
    if layer is not None:
        layer.over(picture)
    return picture.astype(np.uint8)
