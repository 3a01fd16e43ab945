"""`farhand loopback` and `farhand experiment`: both sites, or parts of them, simulated and measured."""

from pathlib import Path
from typing import Annotated

import typer

from common.errors import ConfigError
from farhand.commands.completion import arm_names, driver_names, experiment_names, motion_names, tracker_names
from farhand.commands.options import (
    TRACKER_HELP,
    AsJson,
    Emulate,
    Settings,
    emulation,
    known_tracker,
    until_signal,
)
from farhand.terminal import tell

SECONDS = 30.0


def loopback(
    seconds: Annotated[
        float | None, typer.Option(help="How long to run; 0 until Ctrl-C, as with --open; else 30.", min=0)
    ] = None,
    headless: Annotated[bool, typer.Option("--headless", help="Leave the operator's page out.")] = False,
    open_page: Annotated[
        bool, typer.Option("--open", help="Show the operator's page in the browser, and run until Ctrl-C.")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="Where the page is served, 0: anywhere; else 8470, or anywhere if taken."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write all figures to this JSON file; an earlier one is replaced.")
    ] = None,
    config: Annotated[
        list[Path] | None,
        typer.Option(
            "--config", help="TOML file of one site, known by its tables; twice for both sites, or thesis: at its rate."
        ),
    ] = None,
    settings: Settings = None,
    driver: Annotated[
        str | None,
        typer.Option(
            help="simulated (physics), kinematic (perfect), c500c or franka (emulated), or an installed one.",
            autocompletion=driver_names,
        ),
    ] = None,
    motion: Annotated[
        str | None,
        typer.Option(help="What the simulated operator does; else pick_and_place.", autocompletion=motion_names),
    ] = None,
    tracker: Annotated[
        str | None, typer.Option(help=TRACKER_HELP, autocompletion=tracker_names, callback=known_tracker)
    ] = None,
    arm: Annotated[
        str | None,
        typer.Option(
            help="a465, fr3, or humanoid: an upright torso with a right arm of seven axes.", autocompletion=arm_names
        ),
    ] = None,
    emulate: Emulate = False,
    save_views: Annotated[
        Path | None, typer.Option(help="Folder for the last views, as PNG; earlier ones are replaced.")
    ] = None,
    record: Annotated[Path | None, typer.Option(help="Record the run into this new MCAP file.")] = None,
    as_json: AsJson = False,
) -> None:
    """Run both sites on this machine against a simulated operator and a simulated cell, and measure.

    A file's endpoints are not used: the loopback connects the sites itself. A driver of a real robot MOVES it.

    Example: farhand loopback --seconds 30 --config remote.toml --set driver.name=kinematic
    """
    from farhand.deployment.shipped import configuration_files
    from farhand.loopback.measured_run import run_loopback
    from farhand.loopback.page_port import show_page
    from farhand.loopback.plan import LoopbackOptions

    files = tuple(file for each in config or () for file in configuration_files(each))
    given = files, (*(settings or ()), *emulation(emulate))
    if headless and (open_page or port is not None):
        raise ConfigError("--headless leaves the page out; leave --open and --port out too")
    if seconds is None:
        seconds = 0.0 if open_page else SECONDS
    wanted = seconds, report, driver, motion, tracker, arm, save_views, headless, port, record
    shows = show_page if open_page else lambda _: ""
    run_loopback(LoopbackOptions(*wanted, *given), until_signal(), as_json=as_json, shows=shows)


def experiment(
    name: Annotated[
        str,
        typer.Argument(
            help="follow, hazel, robonaut or another that the shell completes; all: each that is the same every time.",
            autocompletion=experiment_names,
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder for report, plots and data; other files in it stay.")],
    quick: Annotated[bool, typer.Option("--quick", help="A short motion, to see that it works.")] = False,
    as_json: AsJson = False,
) -> None:
    """Run an experiment on the simulated operator and write report.html, report.json, plots (PNG) and data (CSV).

    Example: farhand experiment follow --out build/follow
    """
    from farhand.commands.laboratory import experiments

    summary = experiments().run_experiment(name, out, quick, until_signal())
    tell(summary.splitlines(), {"folder": out, "summary": summary}, as_json=as_json)
