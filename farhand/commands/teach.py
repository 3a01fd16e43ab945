"""`farhand teach`: a recorded task as way points, looked at, and run again."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from farhand.commands.options import AsJson, ConfigFile, Settings, load_own, until_signal
from farhand.terminal import show_table, tell

teach_app = typer.Typer(
    help="Do a task by hand once, and run it again.\n\nExample: farhand teach show task.toml", no_args_is_help=True
)

TaskPath = Annotated[Path, typer.Argument(help="The task file.")]
Frame = Annotated[
    str, typer.Option(help="The taught frame in the base frame, as x,y,z or x,y,z,yaw in mm and deg.", metavar="X,Y,Z")
]


@teach_app.command("extract")
def extract(
    file: Annotated[Path, typer.Argument(help="A recording of the remote site; the parts that follow it count too.")],
    out: Annotated[Path, typer.Option(help="The task file, which does not exist yet.")],
    episode: Annotated[int | None, typer.Option(min=1, help="Which; else the only one.")] = None,
    tolerance_mm: Annotated[float, typer.Option(min=0.1, max=50, help="How far way points leave the path, mm.")] = 2.0,
    tolerance_deg: Annotated[float, typer.Option(min=0.1, max=45, help="The same of the orientation, deg.")] = 2.0,
    frame: Frame = "",
    as_json: AsJson = False,
) -> None:
    """Reduce the tool's path of a recorded episode to way points, in a file that is meant to be edited.

    Example: farhand teach extract recordings/20260102T030405Z_cell_001.mcap --episode 3 --out task.toml
    """
    from farhand.outputs import check_new_file, write_result
    from farhand.teach.extraction import extracted
    from farhand.teach.task_run import frame_from
    from farhand.teach.writing import as_toml

    check_new_file("--out", out, [file])
    with tempfile.TemporaryDirectory() as folder:
        task = extracted(file, Path(folder), episode, tolerance_mm, tolerance_deg, frame_from(frame))
    write_result(out, as_toml(task).encode())
    count = len(task.waypoints)
    words = f"{out}: {count} way points; edit it, look at it with: farhand teach show {out}"
    tell([words], {"task": out, "way_points": count}, as_json=as_json)


@teach_app.command("show")
def show(
    file: TaskPath,
    out: Annotated[
        Path | None, typer.Option(help="A picture of the path as well, as PNG; an earlier one is replaced.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print a task's way points, with when the tool is at each of them, and draw its path.

    Example: farhand teach show task.toml --out task.png
    """
    from farhand.outputs import check_file
    from farhand.reports.plotting import require_matplotlib
    from farhand.teach.show import as_builtins, as_table, plotted
    from farhand.teach.task_file import load_task

    task = load_task(file)
    if out is not None:
        require_matplotlib()
        check_file("--out", out, [file])
        plotted(task).savefig(out, format="png")
    if as_json:
        tell((), as_builtins(task), as_json=True)
    else:
        show_table(as_table(task))


@teach_app.command("run")
def run(
    file: TaskPath,
    config: ConfigFile = None,
    settings: Settings = None,
    speed: Annotated[float, typer.Option(min=0.1, max=2.0, help="Times the task's own speed.")] = 1.0,
    step: Annotated[bool, typer.Option("--step", help="Stop at each way point until n is pressed.")] = False,
    frame: Frame = "",
) -> None:
    """Run a task on the robot, while a person holds the key on the operator's page; in place of 'farhand local'.

    --config and --set are the local site's. Each engagement is a new run, after a slow approach from where the arm
    stands. Letting the key go ends it; p pauses it.

    Example: farhand teach run task.toml --config local.toml --speed 0.5
    """
    from farhand.teach.task_run import frame_from, run_task
    from local_site.config import LocalConfig

    local = load_own(LocalConfig, config, settings or ())
    run_task(file, frame_from(frame), speed, local, until_signal(), stepwise=step)
