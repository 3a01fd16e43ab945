"""The FR3's model: its tool is where the maker's is, and its shapes cover the maker's."""

import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from common.geometry import Array
from remote_site.kinematics.limits import load_arm
from remote_site.kinematics.model import ArmModel
from remote_site.safety.unguarded import unguarded
from tests.remote_site.drivers.franka.fake_robot import CONFIG

# Of the maker's interface at its usual start posture, where the tool points down: the hand's centre point, m.
READY = np.radians([0.0, -45.0, 0.0, -135.0, 0.0, 90.0, 45.0])
READY_M = (0.3069, 0.0, 0.4869)
COVERED_M = 0.010
EDGE_M = 0.02  # the base's lower edge stands on the table

with_assets = pytest.mark.skipif(find_spec("franky_sim") is None, reason="franky_sim missing: make franka")


@pytest.fixture(scope="module")
def model() -> ArmModel:
    return load_arm(CONFIG.robot)[0]


def assets() -> Path:
    import franky_sim

    return Path(franky_sim.__file__).parent / "assets"


def test_the_tool_is_where_the_maker_says(model: ArmModel) -> None:
    pose = model.forward(READY)
    assert np.allclose(pose[:3, 3], READY_M, atol=1e-4)
    assert np.allclose(pose[:3, 2], (0.0, 0.0, -1.0), atol=1e-6)


def test_all_but_one_pair_is_guarded(model: ArmModel) -> None:
    assert unguarded(CONFIG.robot, CONFIG.safety, model) == (
        "fr3_link5 against fr3_link7 (safety.collision.ignored_pairs)",
    )


@with_assets
def test_the_tool_is_where_the_makers_own_model_has_it(model: ArmModel) -> None:
    makers = pin.buildModelFromXML(
        re.sub(r"<(visual|collision).*?</\1>", "", (assets() / "fr3.urdf").read_text(), flags=re.S)
    )
    data, frame = makers.createData(), makers.getFrameId("fr3_hand_tcp")
    for q in np.random.default_rng(5).uniform(model.lower, model.upper, (20, 7)):
        pin.framesForwardKinematics(makers, data, np.array([*q, *np.zeros(makers.nq - 7)]))
        assert np.allclose(model.forward(q), data.oMf[frame].homogeneous, atol=1e-6)


@with_assets
@pytest.mark.parametrize("link", range(8))
def test_the_shapes_cover_the_makers(link: int) -> None:
    corners = _corners(assets() / "meshes" / f"link{link}_coll.stl")
    if link == 0:
        corners = corners[corners[:, 2] > EDGE_M]
    outside = np.min([_outside(corners, shape) for shape in _capsules(f"fr3_link{link}")], axis=0)
    assert outside.max() < COVERED_M


def _corners(stl: Path) -> Array:
    content = stl.read_bytes()
    triangle = np.dtype([("normal", "<3f4"), ("corners", "<9f4"), ("attribute", "<u2")])
    corners: Array = np.frombuffer(content[84:], dtype=triangle)["corners"].reshape(-1, 3).astype(float)
    return corners


def _capsules(link: str) -> list[tuple[Array, float, float]]:
    """Each capsule's placement in the link, radius and half length."""
    arm = pin.buildModelFromUrdf(str(CONFIG.robot.urdf))
    shapes = pin.buildGeomFromUrdf(arm, str(CONFIG.robot.urdf), pin.GeometryType.COLLISION).geometryObjects
    own = [shape for shape in shapes if arm.frames[shape.parentFrame].name == link]
    links = [arm.frames[shape.parentFrame].placement.inverse() * shape.placement for shape in own]
    return [
        (placement.homogeneous, shape.geometry.radius, shape.geometry.halfLength)
        for placement, shape in zip(links, own, strict=True)
    ]


def _outside(points: Array, shape: tuple[Array, float, float]) -> Array:
    placement, radius, half = shape
    local = (points - placement[:3, 3]) @ placement[:3, :3]
    local[:, 2] -= np.clip(local[:, 2], -half, half)
    distances: Array = np.linalg.norm(local, axis=1) - radius
    return distances
