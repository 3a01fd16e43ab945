"""`farhand local`."""

from pathlib import Path
from typing import Annotated

import typer

from common.config import load_config
from common.process.log import LogFormat
from farhand.commands.options import ConfigFile, LogLines, Settings, until_signal


def local(
    config: ConfigFile = None,
    settings: Settings = None,
    save_views: Annotated[Path | None, typer.Option(help="Folder for the last annotated views, as PNG.")] = None,
    log_format: LogLines = LogFormat.TEXT,
) -> None:
    """Start the operator's side: track the arm and publish it.

    Example: farhand local --config local.toml
    """
    from farhand.outputs import check_folder
    from local_site.config import LocalConfig
    from local_site.runtime.app import run_local

    check_folder("--save-views", save_views)
    run_local(load_config(LocalConfig, config, settings or ()), until_signal(), save_views, log_format)
