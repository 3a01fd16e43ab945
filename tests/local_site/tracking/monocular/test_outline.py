"""The outline of the arm's sections lies on the edge of its meshes as they are rendered."""

import cv2
import numpy as np
import pytest

from common.geometry import rotation_from_vector
from local_site.calibration.physical_camera import Lens
from local_site.kernels.rasterising import NOTHING, rasterise
from local_site.tracking.config import ForearmConfig, UpperArmConfig
from local_site.tracking.monocular.arm_model import facing, forearm_mesh, upper_arm_mesh
from local_site.tracking.monocular.outline_fit import hidden, sides_of

LENS = Lens(655.0, 650.0, 319.5, 239.5)
JOINT = np.array([-0.12, -0.04, 1.2])


@pytest.mark.parametrize("mesh", [upper_arm_mesh(UpperArmConfig()), forearm_mesh(ForearmConfig())])
@pytest.mark.parametrize("tilt", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("turn", [0.0, 0.8])
def test_the_sides_lie_on_the_rendered_edge(mesh, tilt, turn):
    rotation = facing(np.array([np.cos(0.4) * np.cos(tilt), np.sin(0.4) * np.cos(tilt), np.sin(tilt)]), turn)
    in_camera = mesh.vertices @ rotation.T + JOINT
    pixels = in_camera[:, :2] / in_camera[:, 2:] * (LENS.fx, LENS.fy) + (LENS.cx, LENS.cy)
    raster = rasterise(pixels, in_camera[:, 2].copy(), mesh.triangles, 640, 480)
    mask = (raster.triangle != NOTHING).astype(np.uint8)
    (contour,) = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    sides = sides_of(mesh.sections, (JOINT, rotation), LENS)
    inner = sides[:, 1:-1].reshape(-1, 2).astype(np.float32)
    off = [abs(cv2.pointPolygonTest(contour, (float(x), float(y)), True)) for x, y in inner]
    assert max(off) < 1.5  # the contour runs through pixels' centres, half a pixel within the edge
    assert np.mean(off) < 0.7


def test_what_lies_well_within_a_link_is_hidden_by_it():
    mesh = upper_arm_mesh(UpperArmConfig())
    rotation = rotation_from_vector(np.array([0.0, np.pi / 2, 0.0]))
    sides = sides_of(mesh.sections, (JOINT, rotation), LENS)
    middle = sides.mean(axis=0)
    assert hidden(middle[3:-3], sides).all()
    assert not hidden(middle + np.array([0.0, 200.0]), sides).any()
