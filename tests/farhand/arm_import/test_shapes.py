"""Capsules enclose what they are made around, and are hardly larger than they have to be."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.errors import ModelError
from farhand.arm_import.description.elements import Inertial, Shape, UrdfBox, UrdfLink, UrdfMesh
from farhand.arm_import.shapes.capsule import Capsule, enclosing_capsule
from farhand.arm_import.shapes.capsules_of import capsule_of, shape_of
from farhand.arm_import.shapes.covering import below, covering
from farhand.arm_import.shapes.links import cover_link, estimated, usable
from farhand.arm_import.shapes.meshes import read_triangles
from tests.farhand.arm_import.published import box_stl, box_triangles

BEAM = box_triangles((0.2, 0.02, 0.02), (0.0, 0.0, 0.0))
CORNER = np.concatenate([BEAM, box_triangles((0.02, 0.02, 0.2), (0.18, 0.0, 0.22))])  # an L


@pytest.mark.slow
@given(st.integers(0, 10_000), st.integers(1, 40))
def test_no_point_is_outside(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 3)) * [0.3, 0.1, 0.05]
    assert enclosing_capsule(points, exactly=seed % 2 == 0).outside(points) <= 1e-9


def test_a_capsule_is_found_again():
    rng = np.random.default_rng(1)
    true = Capsule(np.array([0.1, 0.0, 0.2]), np.array([0.3, 0.2, 0.5]), 0.07)
    around = rng.normal(size=(2000, 3))
    around *= true.radius / np.linalg.norm(around, axis=1)[:, None]
    points = true.start + rng.uniform(size=(2000, 1)) * (true.end - true.start) + around
    assert enclosing_capsule(points).volume < 1.02 * true.volume


def test_an_l_is_covered_by_two_that_leave_no_part_of_its_surface_out():
    capsules = covering(CORNER)
    assert len(capsules) >= 2
    weights = np.random.default_rng(2).dirichlet([1, 1, 1], size=(len(CORNER), 200))
    points = np.einsum("tka,tac->tkc", weights, CORNER).reshape(-1, 3)
    outside = np.min([[c.outside(p[None]) for p in points] for c in capsules], axis=0)
    assert outside.max() <= 1e-9
    assert sum(c.volume for c in capsules) < 0.7 * enclosing_capsule(CORNER.reshape(-1, 3)).volume


def test_a_cut_keeps_both_parts_of_every_triangle():
    def area(triangles):
        a, b, c = np.swapaxes(triangles, 0, 1)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2

    axis = np.array([0.6, 0.0, 0.8])
    one, other = below(CORNER, axis, 0.1), below(CORNER, -axis, -0.1)
    assert (one @ axis).max() <= 0.1 + 1e-12
    assert area(one) + area(other) == pytest.approx(area(CORNER))


def test_a_capsule_is_written_as_the_cylinder_that_counts_as_it():
    capsule = Capsule(np.array([0.0, 0.1, 0.0]), np.array([0.2, 0.1, 0.3]), 0.05)
    again = capsule_of(shape_of(capsule))
    ends = sorted([again.start.tolist(), again.end.tolist()])
    assert ends == [pytest.approx(capsule.start.tolist()), pytest.approx(capsule.end.tolist())]
    assert again.radius == capsule.radius


def test_a_mesh_that_is_none_is_named(tmp_path):
    broken = tmp_path / "broken.stl"
    broken.write_text("hello")
    with pytest.raises(ModelError, match=r"broken.stl cannot be read.*as STL, OBJ or Collada"):
        read_triangles(broken, (1, 1, 1))


def test_a_scale_is_the_meshs_own(tmp_path):
    (tmp_path / "box.stl").write_bytes(box_stl((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)))
    assert np.ptp(read_triangles(tmp_path / "box.stl", (0.001, 0.002, 1.0)).reshape(-1, 3), axis=0) == pytest.approx(
        [0.002, 0.004, 2.0]
    )


def test_visuals_are_covered_where_there_is_no_collision_element(tmp_path):
    (tmp_path / "box.stl").write_bytes(box_stl((0.1, 0.1, 0.1), (0.0, 0.0, 0.0)))
    covered = cover_link(
        UrdfLink("l", visuals=(Shape(np.eye(4), UrdfMesh("box.stl")),)), lambda name: tmp_path / name, moves=True
    )
    assert len(covered.link.collisions) == 1
    assert "its visuals were covered instead" in covered.notes[0]
    assert covered.estimated
    assert usable(covered.link.inertial)


def test_a_link_whose_visuals_cannot_be_read_either_says_that_it_keeps_no_distance():
    def nowhere(name):
        raise ModelError(f"there is no file {name}")

    covered = cover_link(UrdfLink("l", visuals=(Shape(np.eye(4), UrdfMesh("gone.dae")),)), nowhere, moves=False)
    assert covered.link.collisions == ()
    assert "keeps no distance" in covered.notes[0]
    assert covered.dropped


@pytest.mark.parametrize(
    "inertial",
    [
        None,
        Inertial(0.0, np.zeros(3), np.eye(3)),
        Inertial(1.0, np.zeros(3), np.diag([1.0, 1.0, 3.0])),
        Inertial(1.0, np.zeros(3), np.zeros((3, 3))),
    ],
)
def test_what_no_body_can_have_is_replaced(inertial):
    box = Shape(np.eye(4), UrdfBox((0.1, 0.1, 0.3)))
    assert not usable(inertial)
    assert usable(cover_link(UrdfLink("l", collisions=(box,), inertial=inertial), Path, moves=True).link.inertial)


def test_an_estimated_mass_is_the_density_times_the_volume():
    capsule = Capsule(np.zeros(3), np.array([0.0, 0.0, 0.2]), 0.05)
    found = estimated([capsule])
    assert found.mass_kg == pytest.approx(1500 * capsule.volume)
    assert found.centre_m == pytest.approx([0, 0, 0.1])
