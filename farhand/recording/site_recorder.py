"""Records the site of a configuration, the remote or the local one, known by its tables."""

from collections.abc import Callable, Sequence
from datetime import datetime
from importlib.metadata import version
from pathlib import Path

import structlog

from common.config.loading import apply_setting, load_config, read_tables
from common.errors import ConfigError, FarhandError
from common.process.log import LogFormat, log_end, start_log
from common.process.service import StopFlag, be_nice
from common.recording.folder import make_private, recordings_folder
from common.recording.session import RecordingPlan
from farhand.deployment.kinds import known_keys
from farhand.deployment.mix_ups import mix_up
from farhand.outputs import check_new_file
from local_site.config import LocalConfig
from remote_site.config import RemoteConfig

FOLDERS = {RemoteConfig: "recordings", LocalConfig: "operator-recordings"}  # apart, where one host has both sites
NICE = 5  # nobody waits for it, but what it is too late for is lost


def run_recorder(
    config: Path | None,
    settings: Sequence[str],
    out: Path | None,
    file: Path | None,
    date: Callable[[], datetime],
    should_stop: StopFlag,
    log_format: LogFormat = LogFormat.TEXT,
) -> None:
    """Record until asked to stop, into the folder `out`, by default the configured one, or all into one `file`.

    ConfigError for a folder that cannot be written, or that others may look into, and for a file that exists.
    """
    loaded = load_site(config, settings)
    folder = out or recordings_folder(loaded.record.folder, FOLDERS[type(loaded)])
    if file is None:
        make_private(folder)
    else:
        check_new_file("--file", file)
    start_log("record", log_format)
    be_nice(NICE)
    plan = RecordingPlan(folder, loaded.cell, f"farhand {version('farhand')}", loaded.record, file)
    try:
        _record(loaded, plan, date, should_stop)
    except FarhandError as error:
        structlog.get_logger().error("ending", reason=str(error))
        raise
    log_end()


def load_site(config: Path | None, settings: Sequence[str]) -> RemoteConfig | LocalConfig:
    """The configuration of the site whose tables it has, of the remote site where that is not clear."""
    table = read_tables(config)
    for setting in settings:
        apply_setting(table, setting)
    try:
        if known_keys(table, LocalConfig) > known_keys(table, RemoteConfig):
            return load_config(LocalConfig, config, settings)
        return load_config(RemoteConfig, config, settings)
    except ConfigError as error:
        if config is not None and (sentence := mix_up(config, RemoteConfig, LocalConfig)):
            raise ConfigError(sentence) from error
        raise


def _record(
    config: RemoteConfig | LocalConfig, plan: RecordingPlan, date: Callable[[], datetime], should_stop: StopFlag
) -> None:
    if isinstance(config, LocalConfig):
        from local_site.recording.recorder import record_operator  # noqa: PLC0415  # only one of both is needed

        record_operator(config, plan, date, should_stop)
    else:
        from remote_site.recording.recorder import record_cell  # noqa: PLC0415  # as above

        record_cell(config, plan, date, should_stop)
