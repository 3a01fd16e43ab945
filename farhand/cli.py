"""The command line, assembled from its commands; errors that name their cure are printed without a traceback."""

import errno
import sys
from collections.abc import Callable
from importlib.metadata import version
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from common.errors import ConfigError, FarhandError, InterruptionError, NotInstalledError
from common.process.log import finish_log
from common.text import escaped
from farhand.commands.arm import arm_app
from farhand.commands.bash_words import whole_words
from farhand.commands.calibrate import calibrate_app
from farhand.commands.checks import doctor, driver_app, limits, tracker_app
from farhand.commands.configurations import config_app, setup
from farhand.commands.export import export_app
from farhand.commands.files import certificates_app, models_app
from farhand.commands.record import episode_app, record_app
from farhand.commands.replay import replay
from farhand.commands.requests import disengage, engage, lease_app, maintenance_app, reset_arm, stop_arm
from farhand.commands.simulations import experiment, loopback
from farhand.commands.sites import console, local, remote, router, status
from farhand.commands.teach import teach_app
from farhand.commands.track import track
from farhand.exits import FAILED, INTERRUPTED, MISUSE
from farhand.terminal import complain, say

NO_SPACE = errno.ENOSPC, errno.EDQUOT


class InterruptibleGroup(TyperGroup):
    """Commands of which an interruption that they do not answer themselves says that it was one."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command; InterruptionError after Ctrl-C, for which Typer would end without a word."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise InterruptionError("interrupted") from error


app = typer.Typer(
    cls=InterruptibleGroup,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(asked: bool) -> None:
    if asked:
        say(f"farhand {version('farhand')}")
        raise typer.Exit


@app.callback()
def farhand(
    _version: Annotated[
        bool,
        typer.Option("--version", help="Print name and version.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
    """Farhand moves a robot arm somewhere else with a bare hand.

    Example: farhand loopback
    """


PANELS: dict[str, dict[str, Callable[..., None] | typer.Typer]] = {  # in the order in which the help lists them
    "Start": {"loopback": loopback, "remote": remote, "local": local, "console": console, "router": router},
    "Operate": {
        "status": status,
        "engage": engage,
        "disengage": disengage,
        "stop": stop_arm,
        "reset": reset_arm,
        "lease": lease_app,
    },
    "Record": {
        "track": track,
        "replay": replay,
        "record": record_app,
        "episode": episode_app,
        "export": export_app,
        "teach": teach_app,
    },
    "Set up": {
        "setup": setup,
        "config": config_app,
        "calibrate": calibrate_app,
        "models": models_app,
        "certificates": certificates_app,
        "arm": arm_app,
        "driver": driver_app,
        "tracker": tracker_app,
    },
    "Maintain": {"doctor": doctor, "limits": limits, "experiment": experiment, "maintenance": maintenance_app},
}
for panel, commands in PANELS.items():
    for name, command in commands.items():
        if isinstance(command, typer.Typer):
            app.add_typer(command, name=name, rich_help_panel=panel)
        else:
            app.command(name, rich_help_panel=panel)(command)


def main() -> None:
    """Run the command line; the exit codes are those of `farhand.exits`."""
    try:
        try:
            with whole_words():
                app(prog_name="farhand")  # python -m farhand too: its completion is the same command's
        finally:
            finish_log()
    except FarhandError as error:
        complain(error)
        sys.exit(_exit_code(error))
    except OSError as error:
        if error.errno not in NO_SPACE:
            raise
        where = f" {escaped(str(error.filename))}" if error.filename else ""
        print(f"farhand: no space is left to write to{where}; free some, or write elsewhere", file=sys.stderr)  # noqa: T201  # the command line's own voice
        sys.exit(FAILED)


def _exit_code(error: FarhandError) -> int:
    if isinstance(error, ConfigError | NotInstalledError):
        return MISUSE
    return INTERRUPTED if isinstance(error, InterruptionError) else FAILED
