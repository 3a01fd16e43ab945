"""A taught task on the robot: the hand that leads the tool through its way points, while a person holds the key."""

from pathlib import Path

from common.errors import ConfigError, RefusedError
from common.messages.requests import Description
from common.process.service import StopFlag
from farhand.teach.keys import HELP, terminal_keys
from farhand.teach.planning import planned_path
from farhand.teach.task_file import GRIPPER, TaskFile, TaughtFrame, load_task
from farhand.terminal import say
from local_site.config import LocalConfig
from local_site.programmed.path_progress import PathProgress
from local_site.runtime.path_site import PathProgram, run_path


def run_task(
    file: Path, frame: TaughtFrame | None, speed: float, config: LocalConfig, should_stop: StopFlag, *, stepwise: bool
) -> None:
    """Run the task each time that the operator holds the key, until asked to stop; `frame` replaces the taught one.

    ConfigError for a file with mistakes, RefusedError for a cell with another robot.
    """
    task = load_task(file)
    path = planned_path(task, frame.base_T_frame if frame is not None else None)
    start = task.task.gripper_at_start
    say(f"{task.task.name}: {len(task.waypoints)} way points, {path.duration_s:.1f} s without the gripper's; {HELP}")
    with terminal_keys() as keys:
        program = PathProgram(
            "taught",
            task.task.name,
            PathProgress(path, speed, stepwise=stepwise),
            GRIPPER[start] if start is not None else None,
            goes_on=True,
            check=lambda cell: check_robot(task, cell),
            orders=keys.orders,
        )
        run_path(config, program, should_stop, say)


def check_robot(task: TaskFile, cell: Description) -> None:
    """RefusedError where the task was taught on another robot."""
    if task.task.robot != cell.robot:
        raise RefusedError(f"the task was taught on {task.task.robot}, this cell has {cell.robot}: teach it there anew")


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
