"""The recorder's process: steps until it is asked to stop, then ends the recording in order."""

from collections.abc import Callable
from datetime import datetime
from pathlib import Path

import structlog

from common.clock import MonotonicClock
from common.errors import FarhandError, RecordingError
from common.process.log import LogFormat, start_log
from common.process.service import StopFlag, be_nice, notify
from common.recording.folder import make_private, recordings_folder
from common.recording.session import RecordingPlan
from remote_site.config import RemoteConfig
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.memory import memory_path
from remote_site.recording.recorder import CellRecorder

NICE = 5  # as video: nobody waits for it, but what it is too late for is lost
POLL_S = 0.05


def run_recorder(
    config: RemoteConfig,
    out: Path | None,
    file: Path | None,
    software: str,
    date: Callable[[], datetime],
    should_stop: StopFlag,
    log_format: LogFormat = LogFormat.TEXT,
) -> None:
    """Record the site of this configuration until asked to stop, whenever it runs.

    Recordings go to the folder `out`, by default the configured one, or all into one `file`. RecordingError for a
    folder that cannot be written, or that others may look into, and for a file that exists.
    """
    start_log("record", log_format)
    log, clock = structlog.get_logger(), MonotonicClock()
    try:
        folder = out or recordings_folder(config.record.folder)
        if file is None:
            make_private(folder)
        elif file.exists():
            raise RecordingError(f"{file} exists already; give a new file")
        be_nice(NICE)
        plan = RecordingPlan(folder, config.cell, software, config.record, file)
        recorder = CellRecorder(config, plan, SiteAttachment(memory_path(config.cell, config.links)), date)
        notify("READY=1")
        log.info("ready", cell=config.cell, start=config.record.start.value, out=str(file or folder))
        while not should_stop():
            recorder.step(clock.now_ns())
            notify("WATCHDOG=1")
            should_stop.wait(POLL_S)
        notify("STOPPING=1")
        recorder.end(clock.now_ns())
    except FarhandError as error:
        log.error("ending", reason=str(error))
        raise
