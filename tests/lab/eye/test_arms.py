"""Drawn bodies and poses: measures as asked for, bones that stay as long as they are, the same for the same seed."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lab.eye.arms.bodies import FOREARM_M, BodyShape, random_shape, shaped_mesh
from lab.eye.arms.poses import POSTURES_PER_BODY, PoseStore, draw_poses, stored_poses
from lab.eye.arms.postures import random_posture
from lab.eye.arms.surface import skin_attributes, skin_points
from lab.films.arm.arm_mesh import load_arm_mesh
from lab.films.arm.posing import PosedArm
from local_site.simulation.body import BodyPose
from local_site.tracking.eye.arm_points import POINTS

AVERAGE = BodyShape(np.array([1.0, 0.0, 0.0]), 0.26, 0.30, 1.0, 1.0, 1.0, 1.0, 1.0)


@pytest.fixture(scope="module")
def poses() -> PoseStore:
    return draw_poses(2, seed=5, processes=1)


def test_a_body_has_the_lengths_that_were_asked_for() -> None:
    shape = BodyShape(np.array([0.2, 0.3, 0.5]), 0.225, 0.33, 1.2, 0.9, 1.1, 1.05, 0.95)
    mesh = shaped_mesh(shape)
    assert mesh.forearm_m == pytest.approx(0.225, abs=1e-9)
    assert mesh.upper_arm_m == pytest.approx(0.33, abs=1e-9)


def test_girth_is_independent_of_length() -> None:
    thick = BodyShape(AVERAGE.blend, 0.26, 0.30, 1.25, 1.25, 1.0, 1.0, 1.0)
    widths = [_forearm_width(shaped_mesh(shape).vertices) for shape in (AVERAGE, thick)]
    assert widths[1] / widths[0] == pytest.approx(1.25, abs=0.03)


def _forearm_width(vertices: np.ndarray) -> float:
    """How far from its axis the skin of the middle of the forearm is, in the mean."""
    mesh = shaped_mesh(AVERAGE)
    elbow, wrist = mesh.heads[mesh.bone("lowerarm01")], mesh.heads[mesh.bone("wrist")]
    axis = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    along = (vertices - elbow) @ axis
    middle = vertices[(along > 0.3 * mesh.forearm_m) & (along < 0.6 * mesh.forearm_m)] - elbow
    return float(np.linalg.norm(middle - (middle @ axis)[:, None] * axis, axis=1).mean())


def test_fingers_grow_with_the_hand_and_by_themselves() -> None:
    long = BodyShape(AVERAGE.blend, 0.26, 0.30, 1.0, 1.0, 1.1, 1.1, 1.0)
    lengths = []
    for shape in (AVERAGE, long):
        mesh = shaped_mesh(shape)
        lengths.append(np.linalg.norm(mesh.tails[mesh.bone("finger3-3")] - mesh.heads[mesh.bone("finger3-1")]))
    assert lengths[1] / lengths[0] == pytest.approx(1.21, abs=0.02)


def test_bodies_differ_by_more_than_people_do_on_average() -> None:
    random = np.random.default_rng(1)
    forearms = [random_shape(random).forearm_m for _ in range(200)]
    assert min(forearms) < FOREARM_M[0] + 0.01
    assert max(forearms) > FOREARM_M[1] - 0.01


def test_the_hand_goes_on_from_the_forearm_as_at_rest() -> None:
    mesh = load_arm_mesh("average")
    shoulder, elbow, wrist = (mesh.heads[mesh.bone(name)] for name in ("upperarm01", "lowerarm01", "wrist"))
    neutral = PosedArm(mesh).neutral_hand(BodyPose(shoulder, elbow, wrist, np.eye(3), 0.0))
    np.testing.assert_allclose(neutral, mesh.hand_at_rest(), atol=1e-9)


def test_postures_keep_to_what_an_elbow_and_a_wrist_can_do() -> None:
    random, mesh = np.random.default_rng(3), load_arm_mesh("average")
    arm = PosedArm(mesh)
    for _ in range(50):
        pose = random_posture(random, mesh, arm).pose
        assert np.linalg.norm(pose.wrist - pose.elbow) == pytest.approx(mesh.forearm_m)
        assert np.linalg.norm(pose.shoulder - pose.elbow) == pytest.approx(mesh.upper_arm_m)
        bent = np.degrees(np.arccos(pose.operator_R_hand[:, 0] @ (pose.wrist - pose.elbow) / mesh.forearm_m))
        assert bent < 90.0


def test_the_same_seed_draws_the_same_poses(poses: PoseStore) -> None:
    again = draw_poses(2, seed=5, processes=2)
    for name in ("vertices", "body", "rotations", "offsets", "points"):
        np.testing.assert_array_equal(getattr(again, name), getattr(poses, name))


def test_a_bodys_bones_are_as_long_in_every_posture(poses: PoseStore) -> None:
    points = poses.points[:POSTURES_PER_BODY]
    assert points.shape == (POSTURES_PER_BODY, POINTS, 3)
    for start in (2, 6, 10, 14, 18):
        phalanges = np.linalg.norm(np.diff(points[:, start : start + 4], axis=1), axis=2)
        np.testing.assert_allclose(phalanges, np.broadcast_to(phalanges[0], phalanges.shape), atol=1e-4)
    assert np.linalg.norm(points[:, 1], axis=1) == pytest.approx(np.linalg.norm(points[0, 1]), abs=1e-5)


def test_the_tips_lie_on_the_skin(poses: PoseStore) -> None:
    mesh = load_arm_mesh("average")
    turned = np.einsum("bij,vj->vbi", poses.rotations[7], poses.vertices[0]) + poses.offsets[7]
    skin = np.asarray(mesh.fine @ np.einsum("vb,vbi->vi", mesh.weights, turned))
    for tip in poses.points[7, [5, 9, 13, 17, 21]]:
        assert np.linalg.norm(skin - tip, axis=1).min() < 2e-3


def test_poses_are_kept_in_a_file(poses: PoseStore, tmp_path: Path) -> None:
    path = tmp_path / "eye" / "poses.npz"
    drawn = stored_poses(path, 2, 5, 1)
    read = stored_poses(path, 2, 99, 1)  # the file has them: nothing is drawn with this seed
    np.testing.assert_array_equal(read.points, drawn.points)
    np.testing.assert_array_equal(read.points, poses.points)


def test_samples_of_the_skin_lie_close_enough_for_every_pixel() -> None:
    points, mesh = skin_points("hand"), load_arm_mesh("average")
    rest = np.asarray(mesh.fine @ mesh.vertices)
    corners = rest[mesh.triangles[points.triangle]]
    at = np.einsum("pk,pki->pi", points.barycentric, corners)
    on_hand = skin_attributes().along[mesh.triangles[points.triangle]].min(axis=1) > 2.0
    nearest = np.asarray(cKDTree(at[on_hand]).query(at[on_hand][::50], k=2)[0])[:, 1]
    assert np.quantile(nearest, 0.99) < 0.30 / 192  # a pixel of a hand's crop
