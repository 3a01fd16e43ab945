"""The process of the cell's recorder: steps until it is asked to stop, then ends the recording in order."""

import time
from collections.abc import Callable
from datetime import datetime

import structlog

from common.process.service import StopFlag, notify
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingPlan
from remote_site.config import RemoteConfig
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.memory import memory_path
from remote_site.recording.recorder import CellRecorder

POLL_S = 0.05


def record_cell(config: RemoteConfig, plan: RecordingPlan, date: Callable[[], datetime], should_stop: StopFlag) -> None:
    """Record the site of this configuration until asked to stop, whenever it runs."""
    site = SiteAttachment(memory_path(config.cell, config.links))
    recorder = CellRecorder(config, GuardedRecording(plan, date), site)
    notify("READY=1")
    structlog.get_logger().info("ready", cell=config.cell)
    while not should_stop():
        recorder.step(time.monotonic_ns())
        notify("WATCHDOG=1")
        should_stop.wait(POLL_S)
    notify("STOPPING=1")
    recorder.end(time.monotonic_ns())
