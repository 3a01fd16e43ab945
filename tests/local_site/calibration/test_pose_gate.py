"""The live gate: still and new poses are kept, moving, known and half-seen ones are not."""

import numpy as np

from local_site.calibration.boards import STILL_FRAMES, BoardView, PoseGate, moved

IDS = np.arange(12)
GRID = np.stack(np.meshgrid(np.arange(4.0), np.arange(3.0)), axis=-1).reshape(-1, 2) * 40.0


def view(u, v, jitter=0.0, seed=0):
    return BoardView(IDS, GRID + (u, v) + jitter * np.random.default_rng(seed).standard_normal((12, 2)))


def offers(gate, count, pose_at):
    return [gate.offer(pose_at(k)) for k in range(count)]


def test_a_still_board_is_kept_once():
    gate = PoseGate()
    kept = offers(gate, 30, lambda k: (view(0, 0, 0.2, k), view(50, 0, 0.2, k + 100)))
    assert kept.index(True) == STILL_FRAMES
    assert sum(kept) == 1
    assert len(gate.taken) == 1


def test_a_moving_board_is_not_kept():
    assert not any(offers(PoseGate(), 50, lambda k: (view(4 * k, 0), view(4 * k, 0))))


def test_a_new_place_is_kept_and_an_old_one_is_not():
    gate = PoseGate()
    for place, expected in ((0, 1), (100, 1), (10, 0), (200, 1)):
        assert sum(offers(gate, 12, lambda k, place=place: (view(place, 0), view(place, 5)))) == expected  # noqa: ARG005


def test_a_turn_that_only_one_camera_sees_is_new():
    gate = PoseGate()
    assert sum(offers(gate, 12, lambda _: (view(0, 0), view(0, 0)))) == 1
    assert sum(offers(gate, 12, lambda _: (view(2, 0), view(60, 0)))) == 1


def test_one_camera_is_not_enough():
    assert not any(offers(PoseGate(), 30, lambda _: (view(0, 0), None)))
    assert sum(offers(PoseGate(), 30, lambda _: (view(0, 0), None, view(1, 1)))) == 1


def test_views_without_a_common_corner_are_far_apart():
    few = BoardView(np.array([90, 91]), np.zeros((2, 2)))
    assert moved((view(0, 0),), (few,)) == np.inf
    assert moved((None,), (few,)) == np.inf
