"""A taught task on the robot: the hand that leads the tool through its way points, while a person holds the key."""

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from common.errors import ConfigError, RefusedError
from common.geometry import Array
from common.messages.requests import Description
from common.process.service import StopFlag
from farhand.teach.labels import in_words
from farhand.teach.planning import planned_path, way_points_in_base
from farhand.teach.show import in_short
from farhand.teach.task_file import GRIPPER, TaskFile, TaughtFrame, load_task
from farhand.terminal import say
from local_site.config import LocalConfig
from local_site.programmed.path_progress import PathProgress, RunOrder
from local_site.programmed.path_runs import PathProgram
from local_site.runtime.path_site import run_path

NEAR_M = 1e-3  # a recorded path may touch the workspace's side
KEYS = {
    "p": RunOrder.PAUSE,
    "n": RunOrder.NEXT,
    "b": RunOrder.BACK,
    "+": RunOrder.FASTER,
    "-": RunOrder.SLOWER,
}
HELP = "keys here: p pauses and goes on, n to the next way point, b back to the last one, + faster, - slower"
MOST_BYTES = 64


class TerminalKeys:
    """The keys pressed at a terminal, by its descriptor; none without one."""

    def __init__(self, terminal: int | None) -> None:
        self._terminal = terminal

    def orders(self) -> list[RunOrder]:
        """The orders since it was asked last, without waiting for any."""
        if self._terminal is None or not select.select([self._terminal], [], [], 0.0)[0]:
            return []
        pressed = os.read(self._terminal, MOST_BYTES)
        if not pressed:
            self._terminal = None
        return [KEYS[key] for key in pressed.decode(errors="replace") if key in KEYS]


@contextmanager
def terminal_keys() -> Iterator[TerminalKeys]:
    """Keys of standard input come one by one, without Enter, as long as the block lasts; Ctrl-C stays what it is."""
    if not sys.stdin.isatty():
        yield TerminalKeys(None)
        return
    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal)
    try:
        yield TerminalKeys(terminal)
    finally:
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def run_task(
    file: Path, frame: TaughtFrame | None, speed: float, config: LocalConfig, should_stop: StopFlag, *, stepwise: bool
) -> None:
    """Run the task each time that the operator holds the key, until asked to stop; `frame` replaces the taught one.

    ConfigError for a file with mistakes, RefusedError for a cell with another robot.
    """
    task = load_task(file)
    base_T_frame = frame.base_T_frame if frame is not None else None
    path = planned_path(task, base_T_frame)
    start = task.task.gripper_at_start
    say(f"{task.task.name}: {in_short(task, path)}; {HELP}")
    with terminal_keys() as keys:
        program = PathProgram(
            "taught",
            task.task.name,
            PathProgress(path, speed, stepwise=stepwise),
            GRIPPER[start] if start is not None else None,
            goes_on=True,
            check=lambda cell: check_cell(task, way_points_in_base(task, base_T_frame), cell),
            orders=keys.orders,
        )
        run_path(config, program, should_stop, say)


def check_cell(task: TaskFile, base_T_points: Sequence[Array], cell: Description) -> None:
    """RefusedError where the task was taught on another robot, or way points are outside the cell's workspace."""
    if task.task.robot != cell.robot:
        raise RefusedError(f"the task was taught on {task.task.robot}, this cell has {cell.robot}: teach it there anew")
    positions = np.array([pose[:3, 3] for pose in base_T_points])
    low, high = np.array(cell.workspace_min), np.array(cell.workspace_max)
    outside = (positions < low - NEAR_M) | (positions > high + NEAR_M)
    if outside.any():
        point, axis = np.argwhere(outside)[0].tolist()
        numbers = in_words((np.flatnonzero(outside.any(axis=1)) + 1).tolist())
        raise RefusedError(
            f"way points outside the workspace of {cell.cell}: {numbers}; of {point + 1}, {'xyz'[axis]} is "
            f"{1e3 * positions[point, axis]:.0f} mm in the base frame, and may be {1e3 * low[axis]:.0f} to "
            f"{1e3 * high[axis]:.0f}: check [frame] (or --frame) and the way point, in mm and deg"
        )


def frame_from(given: str) -> TaughtFrame | None:
    """The frame of an option, x,y,z or x,y,z,yaw in mm and deg; None where it is empty, ConfigError otherwise."""
    if not given:
        return None
    try:
        x, y, z, *turned = (float(part) for part in given.split(","))
        (yaw,) = turned or [0.0]
        return TaughtFrame(xyz_mm=(x, y, z), rpy_deg=(0.0, 0.0, yaw))
    except ValueError as error:
        raise ConfigError(f"--frame {given!r} is no frame: give x,y,z or x,y,z,yaw in mm and deg") from error
