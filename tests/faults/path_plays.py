"""A taught path under way: what leads the arm is no hand that is seen, and still needs the key of a person."""

import time

import numpy as np

from common.clock import NS_PER_S
from common.geometry import vector_from_rotation
from farhand.teach.task_file import TaskFile, TaskOrigin, WayPoint
from farhand.teach.writing import as_toml
from lab.stage.network.command_socket import send
from tests.faults.cell_pair import MOVING_RAD_S, CellPair
from tests.faults.plays import Play
from tests.faults.process_plays import press_until_engaged
from tests.faults.trial import Trial

WAY_MM, TIMES = np.array([-60.0, 40.0, -50.0]), 12  # there and back
SEEN_S = 5.0  # good samples of half a second would engage the mode automatic
LEAST_MM = 1.0


def restart_in_another_mode(*settings: str) -> Play:
    """The remote site ends in the middle of a path, and starts again with settings under which no key has to be held.

    Nobody is at the key any more. The arm stays, and the program of the path ends with the reason.
    """

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.start_path(_task(pair))
        pair.start_page(pair.start_console())
        pair.wait("readiness", lambda: pair.state.readiness.ready)
        pair.wait("the run", lambda: press_until_engaged(pair))
        pair.wait("the path", lambda: pair.log(time.monotonic_ns() - NS_PER_S).speed_at_end > MOVING_RAD_S / 5, 20)
        trial.begin(lambda pair: send(pair.folder / "page", down=False))
        pair.start_remote(*settings)
        trial.rested_ns = time.monotonic_ns()
        trial.stays(SEEN_S)
        moved_mm = 1e3 * np.ptp(pair.log(trial.rested_ns).positions, axis=0).max()
        trial.note(f"the arm moved by {moved_mm:.2f} mm after the restart")
        trial.check(moved_mm < LEAST_MM, f"the arm moved by {moved_mm:.0f} mm")
        trial.check(pair.local.exit_code == 1, f"the program of the path has not ended: {pair.local.exit_code}")
        trial.check("without a person at the key" in "".join(pair.local.lines), "it does not say why")
        pair.start_remote()
        pair.end_console()

    return play


def _task(pair: CellPair) -> str:
    """Beside where the arm starts, there and back over and over."""
    base_T_tool = pair.model.forward(np.array(pair.config.robot.start))
    turn = np.degrees(vector_from_rotation(base_T_tool[:3, :3]))
    begin = 1e3 * base_T_tool[:3, 3]
    points = [begin + (k % 2) * WAY_MM for k in range(TIMES)]
    way_points = tuple(WayPoint(xyz_mm=tuple(point.tolist()), rotation_deg=tuple(turn.tolist())) for point in points)
    return as_toml(
        TaskFile(task=TaskOrigin(name="there and back", robot=pair.config.robot.model), waypoints=way_points)
    )
