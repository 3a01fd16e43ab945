"""A path reduced to way points: nothing of it is farther from them than the tolerance."""

from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from farhand.teach.extraction import reduced

TOLERANCE_M, TOLERANCE_RAD = 0.002, np.radians(2.0)
WAVE = st.tuples(*[st.floats(-0.15, 0.15)] * 6)


def poses_of(waves, count=120):
    """A smooth path, the sum of waves of position and rotation."""
    t = np.linspace(0.0, 1.0, count)
    path = np.zeros((count, 6))
    for k, wave in enumerate(waves, 1):
        path += np.sin(k * np.pi * t)[:, None] * np.array(wave)
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, 3] = path[:, :3]
    poses[:, :3, :3] = Rotation.from_rotvec(4.0 * path[:, 3:]).as_matrix()
    return poses


def distances(poses, kept):
    """Of each pose from the nearest of many poses on the straight ways between what is kept, each by its tolerance."""
    worst = 0.0
    for begin, end in pairwise(kept):
        part = np.linspace(0.0, 1.0, 401)
        on_way = poses[begin, :3, 3] + part[:, None] * (poses[end, :3, 3] - poses[begin, :3, 3])
        turned = Slerp([0.0, 1.0], Rotation.from_matrix(poses[[begin, end], :3, :3]))(part)
        for pose in poses[begin : end + 1]:
            off = np.linalg.norm(on_way - pose[:3, 3], axis=1) / TOLERANCE_M
            angle = (turned.inv() * Rotation.from_matrix(pose[:3, :3])).magnitude() / TOLERANCE_RAD
            worst = max(worst, float(np.min(np.maximum(off, angle))))
    return worst


@settings(max_examples=15, deadline=None)
@given(st.lists(WAVE, min_size=1, max_size=3))
def test_every_pose_stays_within_the_tolerance(waves):
    poses = poses_of(waves)
    kept = reduced(poses, [], TOLERANCE_M, TOLERANCE_RAD)
    assert kept[0] == 0
    assert kept[-1] == len(poses) - 1
    assert distances(poses, kept) <= 1.05  # of the samples on the way


def test_a_straight_way_keeps_its_ends_and_what_is_to_be_kept():
    poses = np.tile(np.eye(4), (50, 1, 1))
    poses[:, 0, 3] = np.linspace(0.0, 1.0, 50)
    assert reduced(poses, [20], TOLERANCE_M, TOLERANCE_RAD) == [0, 20, 49]


def test_a_turn_in_place_is_kept():
    poses = np.tile(np.eye(4), (41, 1, 1))
    angles = np.concatenate([np.linspace(0.0, 0.5, 21), np.linspace(0.475, 0.0, 20)])
    poses[:, :3, :3] = Rotation.from_rotvec(angles[:, None] * np.array([0.0, 0.0, 1.0])).as_matrix()
    assert 20 in reduced(poses, [], TOLERANCE_M, TOLERANCE_RAD)
