"""`farhand track`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from common.errors import ConfigError
from farhand.commands.completion import tracker_names
from farhand.commands.options import TRACKER_HELP, AsJson, Settings, known_tracker, load_own, until_signal
from farhand.terminal import tell

if TYPE_CHECKING:
    from local_site.config import LocalConfig


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
    out: Annotated[Path, typer.Option(help="JSON lines to write; an earlier track is replaced.")] = Path("track.jsonl"),
    fps: Annotated[
        float | None, typer.Option(help="Frame rate, 0.1 to 1000, where the sources do not state it, or a wrong one.")
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option("--config", help="TOML file of the local site; its tables tracking, drift and gesture count."),
    ] = None,
    settings: Settings = None,
    tracker: Annotated[
        str | None,
        typer.Option(
            help=f"{TRACKER_HELP} The same as --set tracking.method=NAME.",
            autocompletion=tracker_names,
            callback=known_tracker,
        ),
    ] = None,
    annotate: Annotated[
        Path | None, typer.Option(help="Folder for annotated pairs, as PNG; earlier ones are replaced.")
    ] = None,
    video: Annotated[
        Path | None,
        typer.Option(help="Video of the annotated pairs (.mp4), all views side by side; an earlier one is replaced."),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            help="Folder for report.html: tables, plots, the worst pairs; an earlier one is replaced. Needs matplotlib."
        ),
    ] = None,
    csv: Annotated[
        Path | None, typer.Option(help="CSV to write, a row per instant; an earlier one is replaced.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Track a recording or one to four cameras, one JSON line per instant; causal, unsmoothed.

    The exit code is 0 if an instant was tracked, else 1. Degraded ones count as tracked, unless the arm is still being
    learned in them; 130 after Ctrl-C.

    Example: farhand track --rig rig.json --left left.avi --right right.avi --set tracking.silhouette.right_arm=false
    """
    from farhand.tracking.results.outputs import TrackOutputs
    from farhand.tracking.summary import as_builtins, describe, refuse_interrupted, refuse_nothing
    from farhand.tracking.track_run import TrackSources, run_track

    if (monocular is None) == (left is None or right is None) or (monocular and (left or right or also)):
        raise ConfigError("give --left and --right, or --monocular alone")
    if monocular is not None and tracker not in (None, "monocular"):
        raise ConfigError(f"--monocular takes the monocular tracker, not {tracker}: leave out --tracker")
    site = _site(config, settings or [], "monocular" if monocular else tracker, shown_joints)
    sources = TrackSources(rig, monocular or left or "", right, fps, site, tuple(also or ()))
    outputs = TrackOutputs(out, annotate, video, report, csv)
    should_stop = until_signal()
    summary = run_track(sources, outputs, should_stop)
    tell(describe(summary, outputs.written).splitlines(), as_builtins(summary, outputs.written), as_json=as_json)
    if should_stop():
        refuse_interrupted(summary, outputs.written)
    refuse_nothing(summary)


def _site(config: Path | None, settings: Sequence[str], tracker: str | None, shown_joints: str | None) -> "LocalConfig":
    """The local site's configuration with the tracker that is asked for; a warning for each setting left unused."""
    from farhand.tracking.track_run import joint_settings, refuse_other_tracker, unused_settings
    from local_site.config import LocalConfig

    chosen = [] if tracker is None else [f"tracking.method={tracker}"]
    if tracker is not None:
        refuse_other_tracker(tracker, settings)
    chosen += joint_settings(shown_joints) if shown_joints else []
    site = load_own(LocalConfig, config, [*settings, *chosen])
    for sentence in unused_settings(site.tracking, settings):
        typer.echo(f"warning: {sentence}", err=True)
    return site
