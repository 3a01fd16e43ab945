"""Rotations and transforms against scipy, and the hand's frame."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from common import geometry

seeds = st.integers(0, 2**32 - 1)


def random_rotation(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    return Rotation.from_rotvec(
        axis / np.linalg.norm(axis) * rng.choice([1e-7, 0.5, 3.0, np.pi - 1e-6, np.pi])
    ).as_matrix()


@given(seeds)
def test_rotations_agree_with_scipy_and_return(seed: int) -> None:
    matrix = random_rotation(seed)
    quaternion = geometry.quaternion_from_rotation(matrix)
    reference = Rotation.from_matrix(matrix).as_quat()
    assert abs(abs(quaternion @ reference) - 1.0) < 1e-9
    assert np.allclose(Rotation.from_quat(quaternion).as_matrix(), matrix, atol=1e-9)
    vector = geometry.vector_from_rotation(matrix)
    assert np.linalg.norm(vector) <= np.pi + 1e-9
    assert np.allclose(geometry.rotation_from_vector(vector), matrix, atol=1e-9)


@given(seeds, seeds)
def test_the_angle_between_two_orientations_is_that_of_the_turn_from_one_to_the_other(seed: int, other: int) -> None:
    a, b = random_rotation(seed), random_rotation(other)
    turn = np.linalg.norm(geometry.vector_from_rotation(a.T @ b))
    assert geometry.angle_between(a, b) == pytest.approx(turn, abs=1e-7)
    assert geometry.angle_between(a, a @ geometry.rotation_from_vector(np.array([0.0, 1e-7, 0.0]))) == pytest.approx(
        1e-7, rel=1e-6
    )


@given(seeds)
def test_a_transform_times_its_inverse_is_the_identity(seed: int) -> None:
    a_T_b = geometry.transform(random_rotation(seed), np.random.default_rng(seed).normal(size=3))
    assert np.allclose(a_T_b @ geometry.inverse(a_T_b), np.eye(4), atol=1e-12)


@given(seeds)
def test_the_hand_frame_turns_with_the_hand(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wrist, index, thumb = np.zeros(3), np.array([0.16, 0.05, 0.0]), np.array([0.12, -0.04, 0.02])
    rotation, offset = random_rotation(seed), rng.normal(size=3)
    before = geometry.hand_rotation(wrist, index, thumb)
    after = geometry.hand_rotation(*(rotation @ p + offset for p in (wrist, index, thumb)))
    assert before is not None
    assert after is not None
    assert np.allclose(after, rotation @ before, atol=1e-9)
    assert np.linalg.det(before) == pytest.approx(1.0)


def test_collinear_points_have_no_orientation() -> None:
    assert geometry.hand_rotation(np.zeros(3), np.array([0.1, 0, 0]), np.array([0.2, 0, 0])) is None


@given(seeds, st.floats(0.5, 2.0))
def test_a_quaternion_of_another_length_gives_a_rotation_all_the_same(seed: int, length: float) -> None:
    matrix = random_rotation(seed)
    longer = length * geometry.quaternion_from_rotation(matrix)
    assert np.allclose(geometry.rotation_from_quaternion(longer.tolist()), matrix, atol=1e-9)
    assert np.array_equal(geometry.rotation_from_quaternion((0.0, 0.0, 0.0, 0.0)), np.eye(3))
