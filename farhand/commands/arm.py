"""The commands under `farhand arm`: another arm's files."""

import math
import os
from pathlib import Path
from typing import Annotated, Literal

import typer

from common.errors import ConfigError
from farhand.commands.options import AsJson
from farhand.terminal import progress_bar, tell

arm_app = typer.Typer(no_args_is_help=True)


@arm_app.callback()
def arm() -> None:
    """Bring in another arm.

    Example: farhand arm import panda.urdf
    """


@arm_app.command("import")
def import_command(
    urdf: Annotated[Path, typer.Argument(help="The arm's URDF, as its maker publishes it.")],
    out: Annotated[
        Path | None, typer.Option(help="The configuration to write; the arm's URDF is written beside it.")
    ] = None,
    tool: Annotated[
        str | None, typer.Option(help="Frame of the tool centre point, or of a bare flange; else guessed by its name.")
    ] = None,
    base: Annotated[str | None, typer.Option(help="Link by which the arm is fixed in the cell; else the root.")] = None,
    points: Annotated[
        Literal["down", "forward"] | None,
        typer.Option(help="Where the tool points at the start; else where it has more room."),
    ] = None,
    package: Annotated[
        list[str] | None,
        typer.Option(help="NAME=FOLDER: where package://NAME/ is, if not in ROS_PACKAGE_PATH; repeatable."),
    ] = None,
    lock: Annotated[
        list[str] | None, typer.Option(help="JOINT=POSITION in rad or m, of a joint that is not the arm's; repeatable.")
    ] = None,
    jerk: Annotated[
        float | None, typer.Option(help="Jerk in rad/s³ as the maker states it, where the URDF states none.", min=1)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Make a working configuration from an arm's URDF: its limits, shapes, start posture, workspace and simulation.

    Example: farhand arm import panda.urdf --tool panda_hand_tcp --out panda.toml
    """
    from farhand.arm_import.description.packages import packages_given, search_path
    from farhand.arm_import.import_arm import ImportRequest, import_arm

    request = ImportRequest(
        urdf,
        out or Path(f"{urdf.stem}.toml"),
        tool,
        base,
        points,
        packages_given(package or ()),
        search_path(os.environ),
        dict(map(_position, lock or ())),
        jerk,
    )
    with progress_bar() as show:
        lines = import_arm(request, show)
    tell(lines, {"configuration": request.out, "notes": lines}, as_json=as_json)


def _position(option: str) -> tuple[str, float]:
    joint, _, position = option.partition("=")
    try:
        value = float(position)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ConfigError(f"--lock {option}: write it as JOINT=POSITION, a number in rad or m")
    return joint, value
