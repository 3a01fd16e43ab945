"""`farhand setup` and the commands under `farhand config`: configurations made with a person, printed, checked."""

import tomllib
from pathlib import Path
from typing import Annotated

import typer

from farhand.commands.completion import configuration_names
from farhand.commands.options import AsJson
from farhand.exits import FAILED
from farhand.terminal import progress_bar, tell

config_app = typer.Typer(
    help="Print, write and check configurations.\n\nExample: farhand config init sites",
    no_args_is_help=True,
)


def setup(
    out: Annotated[Path, typer.Option(help="Folder for all that is made; a second run goes on from there.")] = Path(
        "setup"
    ),
    camera: Annotated[
        list[str] | None, typer.Option(help="A camera that is not found: device or URL; repeat it for each.")
    ] = None,
) -> None:
    """Set up two cameras with questions and answers: find them, print the board, calibrate, try the tracker, configure.

    Example: farhand setup --out my-setup
    """
    from common.cameras.modes import device_of, list_modes
    from common.cameras.sources import open_camera
    from common.host_clock import MonotonicClock
    from farhand.setup.conversation import TerminalPerson
    from farhand.setup.finding_cameras import find_devices
    from farhand.setup.steps import Tools, set_up
    from farhand.setup.trial import views_for

    person, clock = TerminalPerson(), MonotonicClock()
    named = tuple(camera or ())
    tools = Tools(
        find=lambda: [*named, *(found for found in find_devices() if found not in named)],
        modes=lambda source: list_modes(device) if (device := device_of(source)) else (),
        open=lambda source, name, settings: open_camera(source, name, settings=settings),
        views=lambda cameras, pairing, seconds: views_for(cameras, pairing, clock, seconds),
        progress=progress_bar,
    )
    set_up(out, person, tools)


@config_app.command("show")
def show(
    name: Annotated[
        str,
        typer.Argument(
            help="remote, remote-assist, remote-thesis, local, local-cameras, local-thesis, console or router.",
            autocompletion=configuration_names,
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Print a configuration with every key explained; redirect it to a file to begin one of your own.

    The schema that its first line names to editors is written by 'farhand config schema'.

    Example: farhand config show remote > remote.toml
    """
    from farhand.deployment.shipped import read_configuration

    text = read_configuration(name)
    if as_json:
        tell((), {"name": name, "configuration": tomllib.loads(text)}, as_json=True)
    else:
        typer.echo(text, nl=False)


@config_app.command("init")
def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to; created if missing.")],
    as_json: AsJson = False,
) -> None:
    """Write every configuration and the systemd units to a folder; a file that exists is kept.

    Example: farhand config init my-cell
    """
    from farhand.deployment.shipped import in_words, write_all

    files = write_all(folder)
    tell(in_words(files), {"written": files.written, "kept": files.kept}, as_json=as_json)


@config_app.command("check")
def check(
    files: Annotated[list[Path], typer.Argument(help="Configurations of any site, each known by its tables.")],
    as_json: AsJson = False,
) -> None:
    """Find every mistake of configurations at once, also those for which the arm could not be built.

    The exit code is 1 where there is one. Cameras, ports and certificates are looked at by 'farhand doctor'.

    Example: farhand config check remote.toml local.toml
    """
    from farhand.deployment.checking import check_file

    checked = [check_file(file) for file in files]
    tell([line for file in checked for line in file.in_words()], {"files": checked}, as_json=as_json)
    if any(file.mistakes for file in checked):
        raise typer.Exit(FAILED)


@config_app.command("schema")
def schema(
    out: Annotated[Path, typer.Option(help="Folder beside the configurations, as their first line names it.")] = Path(
        "schemas"
    ),
    as_json: AsJson = False,
) -> None:
    """Write JSON schemas of all configurations, by which editors such as Taplo complete keys and mark mistakes.

    Example: farhand config schema --out my-cell/schemas
    """
    from farhand.deployment.schemas import write_schemas

    written = write_schemas(out, "--out")
    tell([f"wrote {path}" for path in written], {"written": written}, as_json=as_json)
