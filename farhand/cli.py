"""The command line: every command's arguments, its help with an example, and what its exit code says."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import msgspec
import typer

from common.config import load_config
from common.errors import ConfigError, FarhandError, InterruptionError
from common.process.log import LogFormat, finish_log
from common.process.service import StopFlag
from farhand.commands.calibrate import calibrate_app
from farhand.commands.certificates import certificates_app
from farhand.exit_codes import FAILED, INTERRUPTED, MISUSE
from local_site.tracking.config import Method

if TYPE_CHECKING:
    from local_site.console.config import ConsoleConfig

S = TypeVar("S", bound=msgspec.Struct)

ConfigFile = Annotated[Path | None, typer.Option("--config", help="TOML file; the defaults are the simulated pair.")]
TrackingFile = Annotated[
    Path | None,
    typer.Option("--config", help="TOML file of the local site; its tables tracking, drift and gesture count."),
]
LogLines = Annotated[LogFormat, typer.Option("--log-format", help="text (level=... event=...) or json, on stderr.")]
Settings = Annotated[list[str] | None, typer.Option("--set", help="Override one key, as table.key=value.")]

LinksFile = Annotated[
    Path | None, typer.Option("--config", help="The console's TOML file: cell, operator, endpoints and certificates.")
]
CellName = Annotated[str, typer.Option("--cell", help="Name of the cell.")]
RemoteEndpoint = Annotated[str, typer.Option("--remote", help="Control endpoint of the remote site.")]
LocalEndpoint = Annotated[str, typer.Option("--local", help="Where the local site of this host listens.")]

TRACKER_HELP = "A bare arm's silhouette, three bright markers on a dark glove, or a textured arm before one camera."
TrackerName = Annotated[Method, typer.Option(help=TRACKER_HELP)]

app = typer.Typer(
    help="Farhand moves a robot arm somewhere else with a bare hand.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
app.add_typer(calibrate_app, name="calibrate")
app.add_typer(certificates_app, name="certificates")
lease_app = typer.Typer(help="Show who may operate a cell, take the lease, give it away.", no_args_is_help=True)
app.add_typer(lease_app, name="lease")
maintenance_app = typer.Typer(help="Stop and reset the arm, without the right to operate it.", no_args_is_help=True)
app.add_typer(maintenance_app, name="maintenance")
driver_app = typer.Typer(help="Look after robot drivers.", no_args_is_help=True)
app.add_typer(driver_app, name="driver")


def main() -> None:
    """Run the command line; errors that name their cure are printed without a traceback."""
    try:
        try:
            app()
        finally:
            finish_log()
    except ConfigError as error:
        _fail(error, MISUSE)
    except InterruptionError as error:
        _fail(error, INTERRUPTED)
    except FarhandError as error:
        _fail(error, FAILED)


def _fail(error: FarhandError, code: int) -> None:
    print(f"farhand: {error}", file=sys.stderr)  # noqa: T201  # the command line's own voice
    sys.exit(code)


def _until_signal(run: Callable[[StopFlag], None]) -> None:
    should_stop = StopFlag()
    should_stop.install()
    run(should_stop)


@app.command()
def local(
    config: ConfigFile = None,
    settings: Settings = None,
    save_views: Annotated[Path | None, typer.Option(help="Folder for the last annotated views, as PNG.")] = None,
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the operator's side: track the arm and publish it.

    Example: farhand local --config deploy/sites/local.toml
    """
    from farhand.outputs import check_folder
    from local_site.config import LocalConfig
    from local_site.runtime.app import run_local

    check_folder("--save-views", save_views)
    loaded = load_config(LocalConfig, config, settings or ())
    _until_signal(lambda should_stop: run_local(loaded, should_stop, save_views, log_format))


@app.command()
def remote(
    config: ConfigFile = None,
    settings: Settings = None,
    driver: Annotated[str | None, typer.Option(help="The robot's driver: the same as --set driver.name=NAME.")] = None,
    emulate: Annotated[bool, typer.Option("--emulate", help="c500c: against an emulated controller.")] = False,
    cell: Annotated[str, typer.Option(help="Name of this cell: the same as --set cell=NAME.")] = "",
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the robot's side: follow the hand inside the limits, and stream the cell.

    Example: farhand remote --config deploy/sites/remote.toml --driver kinematic
    """
    from remote_site.config import RemoteConfig
    from remote_site.runtime.app import run_remote

    chosen = ([f"driver.name={driver}"] if driver else []) + (["driver.emulate=true"] if emulate else [])
    chosen += [f"cell={cell}"] if cell else []
    loaded = load_config(RemoteConfig, config, [*(settings or ()), *chosen])
    _until_signal(lambda should_stop: run_remote(loaded, should_stop, log_format))


@app.command()
def router(
    config: ConfigFile = None,
    settings: Settings = None,
    zenohd: Annotated[bool, typer.Option("--zenohd", help="Only print the same as zenohd's configuration.")] = False,
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the meeting point for sites that cannot reach each other, as behind NAT.

    Example: farhand router --config deploy/sites/router.toml
    """
    from farhand.router import RouterConfig, run_router, zenohd_configuration

    loaded = load_config(RouterConfig, config, settings or ())
    if zenohd:
        typer.echo(zenohd_configuration(loaded))
    else:
        _until_signal(lambda should_stop: run_router(loaded, should_stop, log_format))


@driver_app.command("test")
def driver_test_command(
    name: Annotated[str, typer.Argument(help="The driver's name, as in driver.name.")],
    config: ConfigFile = None,
    settings: Settings = None,
) -> None:
    """Check a driver against everything that Farhand expects of one; it MOVES every joint, the first by 40 degrees.

    Example: farhand driver test kinematic
    """
    from farhand.commands.driver import test_driver
    from remote_site.config import RemoteConfig

    loaded = load_config(RemoteConfig, config, [*(settings or ()), f"driver.name={name}"])
    if not test_driver(loaded, typer.echo):
        raise typer.Exit(FAILED)


@app.command()
def engage(
    cell: CellName = "",
    at: RemoteEndpoint = "",
    operator: Annotated[str, typer.Option(help="The operator's name, where it is not this host's.")] = "",
    config: LinksFile = None,
) -> None:
    """Let the arm follow the hand again, after a stop or a restart of the local site.

    Example: farhand engage --cell cell
    """
    from farhand.commands.engage import request_engage

    links = _links(config, cell=cell, control=at)
    typer.echo(request_engage(links.cell, links.links.control, operator or links.name, links.links))


def _links(config: Path | None, **told: str) -> "ConsoleConfig":
    """Whom to ask, how protected: the console's configuration, and over it what the command line tells."""
    from local_site.console.config import ConsoleConfig

    settings = [f"{key if key == 'cell' else f'links.{key}'}={value}" for key, value in told.items() if value]
    return load_config(ConsoleConfig, config, settings)


@app.command()
def console(config: ConfigFile = None, settings: Settings = None, log_format: LogLines = LogFormat.TEXT) -> None:
    """Serve the operator's page: the cell's views, what the arm does and why, and its brakes.

    Example: farhand console --config deploy/sites/console.toml
    """
    from local_site.console.app import run_console
    from local_site.console.config import ConsoleConfig

    loaded = load_config(ConsoleConfig, config, settings or ())
    _until_signal(lambda should_stop: run_console(loaded, should_stop, typer.echo, log_format))


@app.command()
def doctor(
    config: Annotated[
        Path | None, typer.Option("--config", help="TOML file of either site; without one, both sites' defaults.")
    ] = None,
    settings: Settings = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as JSON.")] = False,
) -> None:
    """Check this machine and a configuration, and say what to do; the exit code is 1 when something is an error.

    Example: farhand doctor --config /etc/farhand/local.toml
    """
    from farhand.doctor import findings
    from farhand.doctor.run import examine

    found = examine(config, settings or ())
    typer.echo(findings.as_json(found) if as_json else findings.as_text(found))
    if findings.worst(found) is findings.Severity.ERROR:
        raise typer.Exit(FAILED)


@lease_app.command("show")
def lease_show(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Show who holds the lease of a cell, who asks for it, and what engaging still lacks.

    Example: farhand lease show --cell cell
    """
    from farhand.commands.lease import show_lease

    links = _links(config, cell=cell, control=at)
    typer.echo(show_lease(links.cell, links.links.control, links.links))


@lease_app.command("take")
def lease_take(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None) -> None:
    """Ask for the lease; while another operator holds it, ask for a minute for consent.

    Example: farhand lease take
    """
    _act_on_lease("take", _links(config, cell=cell, local=at))


@lease_app.command("give")
def lease_give(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None) -> None:
    """Consent: hand the lease to the operator who asks for it. The arm stops.

    Example: farhand lease give
    """
    _act_on_lease("give", _links(config, cell=cell, local=at))


@lease_app.command("release")
def lease_release(cell: CellName = "", at: LocalEndpoint = "", config: LinksFile = None) -> None:
    """Give the lease back, for whoever asks first. The arm stops.

    Example: farhand lease release
    """
    _act_on_lease("release", _links(config, cell=cell, local=at))


def _act_on_lease(action: str, links: "ConsoleConfig") -> None:
    from common.messages.requests import OperatorAction
    from farhand.commands.lease import act_on_lease

    typer.echo(act_on_lease(links.cell, links.links.local, OperatorAction(action), links.links))


@maintenance_app.command("stop")
def maintenance_stop(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Stop the arm and bar every engagement until it is reset; needs no lease.

    Example: farhand maintenance stop --config /etc/farhand/maintenance.toml
    """
    _maintain("stop", _links(config, cell=cell, control=at))


@maintenance_app.command("reset")
def maintenance_reset(cell: CellName = "", at: RemoteEndpoint = "", config: LinksFile = None) -> None:
    """Clear a stop or a fault, and wake a robot that has stopped; nothing moves until the operator engages.

    Example: farhand maintenance reset --config /etc/farhand/maintenance.toml
    """
    _maintain("reset", _links(config, cell=cell, control=at))


def _maintain(action: str, links: "ConsoleConfig") -> None:
    from common.messages.requests import EngagementAction
    from farhand.commands.engage import request_maintenance

    typer.echo(request_maintenance(links.cell, links.links.control, EngagementAction(action), links.name, links.links))


@app.command()
def loopback(
    seconds: Annotated[float, typer.Option(help="How long to run; 0 until Ctrl-C.", min=0)] = 30.0,
    headless: Annotated[bool, typer.Option("--headless", help="Leave the operator's page out.")] = False,
    report: Annotated[Path | None, typer.Option(help="Write all figures to this JSON file.")] = None,
    driver: Annotated[
        str, typer.Option(help="simulated (physics), kinematic (perfect) or c500c (emulated).")
    ] = "simulated",
    motion: Annotated[str, typer.Option(help="What the simulated operator does.")] = "pick_and_place",
    tracker: TrackerName = "silhouette",
    arm: Annotated[
        str, typer.Option(help="a465, or humanoid: an upright torso with a right arm of seven axes.")
    ] = "a465",
    save_views: Annotated[Path | None, typer.Option(help="Folder for the last views, as PNG.")] = None,
) -> None:
    """Run both sites on this machine against a simulated operator and a simulated cell, and measure.

    Example: farhand loopback --seconds 30 --report out.json
    """
    from farhand.loopback.run import LoopbackOptions, run_loopback

    options = LoopbackOptions(seconds, report, driver, motion, tracker, arm, save_views, headless)
    _until_signal(lambda should_stop: run_loopback(options, should_stop))


@app.command()
def track(
    rig: Annotated[Path, typer.Option(help="Rig file from 'farhand calibrate'.")],
    left: Annotated[str | None, typer.Option(help="Video file, folder of images, device or URL.")] = None,
    right: Annotated[str | None, typer.Option(help="The same for the right camera.")] = None,
    monocular: Annotated[
        str | None, typer.Option(help="The same for a single camera, instead of left and right: the monocular tracker.")
    ] = None,
    shown_joints: Annotated[
        str | None,
        typer.Option(
            "--joints",
            help="Monocular: shoulder, elbow, wrist in the first picture, 'x,y x,y x,y' (px), or silhouette.",
        ),
    ] = None,
    also: Annotated[
        list[str] | None, typer.Option(help="A third, and given again a fourth camera, in the rig's order.")
    ] = None,
    out: Annotated[Path, typer.Option(help="JSON lines to write.")] = Path("track.jsonl"),
    fps: Annotated[float | None, typer.Option(help="Frame rate, where the sources do not tell it, or wrongly.")] = None,
    config: TrackingFile = None,
    settings: Settings = None,
    tracker: Annotated[
        Method | None, typer.Option(help=f"{TRACKER_HELP} The same as --set tracking.method=NAME.")
    ] = None,
    annotate: Annotated[Path | None, typer.Option(help="Folder for annotated pairs, as PNG.")] = None,
) -> None:
    """Track a recording or one to four cameras, one JSON line per instant; causal, unsmoothed.

    Example: farhand track --rig rig.json --left left.avi --right right.avi --set tracking.silhouette.right_arm=false
    """
    from farhand.commands.track import TrackSources, joint_settings, run_track
    from local_site.config import LocalConfig

    if (monocular is None) == (left is None or right is None) or (monocular and (left or right or also)):
        raise ConfigError("give --left and --right, or --monocular alone")
    chosen = [] if tracker is None else [f"tracking.method={tracker}"]
    chosen += joint_settings(shown_joints) if shown_joints else []
    site = load_config(LocalConfig, config, [*(settings or ()), *chosen])
    sources = TrackSources(rig, monocular or left or "", right, fps, site, tuple(also or ()))
    should_stop = StopFlag()
    should_stop.install()
    typer.echo(run_track(sources, out, annotate, should_stop))
    if should_stop():
        raise InterruptionError(f"interrupted; {out} ends where it was")


@app.command()
def experiment(
    name: Annotated[
        str, typer.Argument(help="follow: hand against tool; hazel: one camera's arm; drift: its command.")
    ],
    out: Annotated[Path, typer.Option(help="Folder for report, plots and data; other files in it stay.")],
    quick: Annotated[bool, typer.Option("--quick", help="A short motion, to see that it works.")] = False,
) -> None:
    """Run an experiment on the simulated operator and write report.html, report.json, plots (PNG) and data (CSV).

    Example: farhand experiment follow --out build/follow
    """
    from farhand.experiments.run import run_experiment

    should_stop = StopFlag()
    should_stop.install()
    typer.echo(run_experiment(name, out, quick, should_stop))
