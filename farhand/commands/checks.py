"""`farhand doctor`, `limits`, and what is under `farhand driver` and `tracker`: checks, and what is installed."""

from pathlib import Path
from typing import Annotated

import typer

from farhand.commands.completion import driver_names
from farhand.commands.options import (
    AsJson,
    ConfigFile,
    Emulate,
    Settings,
    driver_file,
    emulation,
    load_own,
    until_signal,
)
from farhand.exits import FAILED, UNDECIDED
from farhand.terminal import aside, say, show_table, table_of, tell

driver_app = typer.Typer(
    help="List, begin and check robot drivers.\n\nExample: farhand driver list", no_args_is_help=True
)
tracker_app = typer.Typer(help="List the trackers.\n\nExample: farhand tracker list", no_args_is_help=True)


@tracker_app.callback()
def tracker() -> None:
    """A command alone would take its group's name."""


def doctor(
    config: Annotated[
        Path | None, typer.Option("--config", help="TOML file of either site; without one, both sites' defaults.")
    ] = None,
    settings: Settings = None,
    as_json: AsJson = False,
    link: Annotated[
        bool, typer.Option("--link", help="Measure the link to the running remote site instead; nothing moves.")
    ] = False,
) -> None:
    """Check this machine and a configuration, and suggest fixes; the exit code is 1 if any finding is an error.

    Example: farhand doctor --config /etc/farhand/local.toml
    """
    from farhand.doctor import findings
    from farhand.doctor.examination import examine, examine_link_of

    found = (examine_link_of if link else examine)(config, settings or ())
    tell(findings.as_text(found).splitlines(), findings.as_builtins(found), as_json=as_json)
    if findings.worst(found) is findings.Severity.ERROR:
        raise typer.Exit(FAILED)


def limits(
    config: ConfigFile = None,
    settings: Settings = None,
    factor: Annotated[
        float | None,
        typer.Option(
            "--factor", help="Show them with this robot.limits_factor; the file stays as it is.", min=0.01, max=1
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print limits, tool and payload of the robot's side, where each comes from, and how long and far its stops are.

    Example: farhand limits --config /etc/farhand/remote.toml --factor 0.5
    """
    from farhand.limits.report import limits_report
    from farhand.limits.tables import as_builtins, tables_of
    from remote_site.config import RemoteConfig
    from remote_site.kinematics.limits import load_arm
    from remote_site.safety.stop_bound import check_stops

    tried = [] if factor is None else [f"robot.limits_factor={factor}"]
    loaded = load_own(RemoteConfig, config, [*(settings or ()), *tried])
    model, bounds = load_arm(loaded.robot)
    report = limits_report(loaded, model, bounds)
    if as_json:
        tell((), as_builtins(report), as_json=True)
    else:
        for table in tables_of(report):
            say(table.title)
            show_table(table_of(table.head, table.rows))
    check_stops(bounds, loaded.robot.speed, loaded.safety.longest_stop_ms)


@tracker_app.command("list")
def list_trackers(as_json: AsJson = False) -> None:
    """List the trackers by name: where each comes from, and what it tracks.

    Example: farhand tracker list
    """
    from farhand.tracking.listing import installed_trackers

    trackers = installed_trackers()
    tell(map(str, trackers), {"trackers": trackers}, as_json=as_json)


@driver_app.command("list")
def list_drivers(as_json: AsJson = False) -> None:
    """List the drivers by name: where each comes from, what it is, and what is missing where it cannot be used.

    Example: farhand driver list
    """
    from remote_site.drivers.listing import installed_drivers

    drivers = installed_drivers()
    tell(map(str, drivers), {"drivers": drivers}, as_json=as_json)


@driver_app.command("new")
def new_driver(
    name: Annotated[str, typer.Argument(help="The driver's name, as in driver.name.")],
    out: Annotated[Path, typer.Option("--out", help="Folder in which the package's folder NAME is made.")] = Path(),
    as_json: AsJson = False,
) -> None:
    """Write the package of a new driver: three methods to fill in, an arm simulated until then, and its tests.

    Example: farhand driver new my_arm
    """
    from farhand.new_driver.package import next_steps, write_package

    written = write_package(name, out)
    words = [*(f"wrote {path}" for path in written), *next_steps(name, out)]
    tell(words, {"written": written}, as_json=as_json)


@driver_app.command("test")
def run_suite(
    name: Annotated[str, typer.Argument(help="The driver's name, as in driver.name.", autocompletion=driver_names)],
    config: ConfigFile = None,
    settings: Settings = None,
    emulate: Emulate = False,
    as_json: AsJson = False,
) -> None:
    """Check a driver against everything that Farhand expects of one; it MOVES the gripper and every joint, one by 40°.

    Ctrl-C stops the robot first. The exit code is 1 if a check failed, 3 if none did but this machine was too busy to
    judge some: repeat them.

    Example: farhand driver test kinematic
    """
    from remote_site.config import RemoteConfig
    from remote_site.drivers.conformance.verdicts import Verdict
    from remote_site.runtime.conformance import test_driver

    chosen = [*(settings or ()), f"driver.name={name}", *emulation(emulate)]
    loaded = load_own(RemoteConfig, config or driver_file(name), chosen)
    verdicts = test_driver(loaded, aside(as_json=as_json), until_signal())
    tell((), {"driver": name, "checks": verdicts}, as_json=as_json)
    if Verdict.FAILED in verdicts.values():
        raise typer.Exit(FAILED)
    if Verdict.REPEAT in verdicts.values():
        raise typer.Exit(UNDECIDED)
