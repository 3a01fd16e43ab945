"""What the tests of the eye's training share: a few poses, a few tiles of rooms, and one thread."""

from importlib.util import find_spec

import numpy as np
import pytest
from numpy.typing import NDArray

from lab.eye.arms.poses import PoseStore, draw_poses


@pytest.fixture(scope="session", autouse=True)
def _one_thread() -> None:
    """Let torch work with one thread: there are two processes of tests, and threads that wait for a core spin."""
    if find_spec("torch") is not None:
        import torch

        torch.set_num_threads(1)


@pytest.fixture(scope="session")
def few_poses() -> PoseStore:
    """Three bodies, each in 100 postures."""
    return draw_poses(3, seed=11, processes=1)


@pytest.fixture(scope="session")
def few_tiles() -> NDArray[np.uint8]:
    """Tiles of noise, which the rooms are made of."""
    return np.random.default_rng(1).integers(0, 255, (6, 64, 64, 3), dtype=np.uint8)
