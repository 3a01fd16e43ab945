"""A recorded episode on a robot again: its hand is published under a lease while a person holds the key."""

from pathlib import Path

from common.messages.requests import Description
from common.process.service import StopFlag
from farhand.replay.recorded_scene import recorded_cell
from farhand.replay.recorded_tool_path import check_cell, recorded_path
from farhand.terminal import say
from local_site.config import LocalConfig
from local_site.programmed.path_progress import PathProgress
from local_site.programmed.path_runs import PathProgram
from local_site.runtime.path_site import run_path


def replay_to_robot(
    file: Path, folder: Path, episode: int | None, speed: float, config: LocalConfig, should_stop: StopFlag
) -> None:
    """Run an episode each time that the operator engages, until asked to stop; `folder` is for files of the moment.

    RecordingError for a recording without such an episode, RefusedError for a cell with another arm.
    """
    recorded_on = recorded_cell(file, folder)
    recorded = recorded_path(file, recorded_on.cell, episode)

    def check(cell: Description) -> None:
        check_cell(recorded_on, cell)

    name = f"episode {recorded.episode} of {file.name}"
    progress = PathProgress(recorded.path, speed, stepwise=False)
    say(f"{name}: {recorded.path.duration_s:.1f} s; hold the key on the operator's page, each time for a new run")
    program = PathProgram(
        "recorded", name, progress, recorded.gripper_at_start, goes_on=False, check=check, orders=tuple
    )
    run_path(config, program, should_stop, say)
