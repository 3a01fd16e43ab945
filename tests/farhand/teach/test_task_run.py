"""What is checked before a task runs in a cell: the robot, and the workspace."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.errors import RefusedError
from farhand.replay.recorded_scene import recorded_cell
from farhand.teach.planning import way_points_in_base
from farhand.teach.task_file import TaughtFrame
from farhand.teach.task_run import check_cell
from tests.farhand.replay.recorded_states import recorded_states
from tests.farhand.teach.example_task import TASK

INSIDE = replace(TASK, frame=TaughtFrame(xyz_mm=(400.0, 0.0, 500.0)))


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recorded")
    return recorded_cell(recorded_states(folder).file, folder)


def check(task, cell):
    check_cell(task, way_points_in_base(task), cell)


@pytest.mark.slow
def test_a_task_runs_on_the_robot_and_in_the_workspace_that_it_was_taught_in(cell):
    check(INSIDE, cell)
    with pytest.raises(RefusedError, match="teach it there anew"):
        check(INSIDE, replace(cell, robot="ur5"))


def test_way_points_outside_the_workspace_are_named_before_anything_moves(cell):
    low = replace(INSIDE, frame=TaughtFrame(xyz_mm=(400.0, 0.0, 230.0)))
    with pytest.raises(RefusedError, match=r"of cell: 2; of 2, z is 230 mm in the base frame, and may be 250 to 1150"):
        check(low, cell)
    in_metres = replace(INSIDE, frame=TaughtFrame(xyz_mm=(0.4, 0.0, 0.5)))
    with pytest.raises(RefusedError, match=r"1–2; of 1, x is 0 mm .* in mm"):
        check(in_metres, cell)


def test_a_path_may_touch_the_workspaces_side(cell):
    side = 1e3 * np.array(cell.workspace_max)[0] + 0.01
    check(replace(INSIDE, frame=TaughtFrame(xyz_mm=(side, 0.0, 500.0))), cell)
