"""Direct linear transformation: exact points give the exact camera."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from local_site.calibration.resection import agreeing, solve_projection, unsolvable
from local_site.calibration.triangulation import project
from tests.local_site.calibration.plate_cameras import GRID, camera


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.floats(-60, 60), st.floats(400, 2000), st.floats(1.6, 5.0))
def test_exact_points_give_back_the_camera(angle, focal, distance):
    truth = camera(angle, focal=focal, distance=distance).projection
    solved = solve_projection(GRID, project(truth, GRID))
    assert np.allclose(solved, truth, rtol=1e-6, atol=1e-5)


def test_points_that_do_not_agree_are_left_out():
    pixels = camera(10.0).pixels(GRID)
    pixels[[3, 40]] += (30.0, -20.0)
    assert np.flatnonzero(~agreeing(GRID, pixels)).tolist() == [3, 40]


def test_a_plane_and_too_few_points_are_known_as_such():
    assert "one plane" in unsolvable(GRID[GRID[:, 2] == 0.5])
    assert "sees 5 control points" in unsolvable(GRID[:5])
    assert unsolvable(GRID) == ""
