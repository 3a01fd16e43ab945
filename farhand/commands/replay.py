"""`farhand replay`: what was recorded, played again."""

import tempfile
from dataclasses import asdict
from itertools import count
from pathlib import Path
from typing import Annotated

import typer

from common.errors import ConfigError
from farhand.commands.options import AsJson, ConfigFile, Settings, load_own, until_signal
from farhand.terminal import progress_bar, say, tell


def replay(
    file: Annotated[Path, typer.Argument(help="A recording; the parts that follow it count too.")],
    verify: Annotated[
        bool, typer.Option("--verify", help="Feed the recorded inputs through today's pipeline; compare the commands.")
    ] = False,
    to_robot: Annotated[
        bool, typer.Option("--to-robot", help="Lead a robot along a recorded episode, in place of 'farhand local'.")
    ] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Where the page is served; 0 takes a free port.")] = 8471,
    episode: Annotated[int | None, typer.Option(min=1, help="With --to-robot: which; else the only one.")] = None,
    speed: Annotated[float, typer.Option(min=0.1, max=1.0, help="With --to-robot: times the recorded speed.")] = 1.0,
    config: ConfigFile = None,
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Show a recording on the operator's page, until Ctrl-C; or verify it, or run it on a robot.

    The page is served to this host only. With --verify every recorded input goes through today's control pipeline: exit
    code 0 if every command comes again, 1 if one differs, as it may where another release recorded it. With --to-robot
    (--config and --set are the local site's) the recorded hand is published in place of the tracked one: it moves the
    arm only while a person who has engaged on the operator's page holds the key, and begins with a slow approach from
    where the arm stands.

    Example: farhand replay recordings/20260102T030405Z_cell_001.mcap
    """
    if verify and to_robot:
        raise ConfigError("--verify and --to-robot exclude each other; give one of them")
    if as_json and not verify:
        raise ConfigError("--json is the verdict of --verify; give both, or leave it out")
    with tempfile.TemporaryDirectory() as folder:
        if to_robot:
            from farhand.replay.to_robot import replay_to_robot
            from local_site.config import LocalConfig

            local = load_own(LocalConfig, config, settings or ())
            replay_to_robot(file, Path(folder), episode, speed, local, until_signal())
            return
        if verify:
            _verify(file, Path(folder), as_json=as_json)
            return
        from farhand.replay.console import run_replay
        from farhand.replay.recorded_scene import RecordedScene
        from local_site.console.config import ServeConfig

        with RecordedScene(file, Path(folder)) as scene:
            run_replay(scene, file.name, ServeConfig(port=port), until_signal(), say)


def _verify(file: Path, folder: Path, *, as_json: bool) -> None:
    from farhand.exits import FAILED
    from farhand.replay.recorded_cycles import cycle_count, other_release, recorded_cycles, recorded_pipeline
    from farhand.replay.verify import verify

    with progress_bar() as show:
        pipeline, total, done = recorded_pipeline(file, folder), cycle_count(file), count(1)
        verdict = verify(recorded_cycles(file), pipeline, lambda: show("verifying", next(done), total))
    is_same = verdict.difference is None
    words = verdict.in_words() if is_same else verdict.in_words(other_release(file))
    tell([words], {"is_same": is_same, **asdict(verdict)}, as_json=as_json)
    if not is_same:
        raise typer.Exit(FAILED)
