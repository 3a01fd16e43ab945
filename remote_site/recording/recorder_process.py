"""The process of the cell's recorder: steps until it is asked to stop, then ends the recording in order."""

import threading
import time
from collections.abc import Callable
from datetime import datetime

import structlog

from common.process.service import StopFlag, notify
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingPlan
from remote_site.config import RemoteConfig
from remote_site.recording.attachment import SiteAttachment
from remote_site.recording.memory_files import memory_place
from remote_site.recording.recorder import CellRecorder

POLL_S = 0.05
BEAT_S = 0.25


def record_cell(config: RemoteConfig, plan: RecordingPlan, date: Callable[[], datetime], should_stop: StopFlag) -> None:
    """Record the site of this configuration until asked to stop, whenever it runs."""
    site, ended = SiteAttachment(memory_place(config.cell, config.links)), threading.Event()
    recorder = CellRecorder(config, GuardedRecording(plan, date), site)
    beats = threading.Thread(target=_beat, args=(site, ended), name="beat", daemon=True)
    beats.start()
    notify("READY=1")
    structlog.get_logger().info("ready", cell=config.cell)
    try:
        while not should_stop():
            recorder.step(time.monotonic_ns())
            notify("WATCHDOG=1")
            should_stop.wait(POLL_S)
        notify("STOPPING=1")
        recorder.end(time.monotonic_ns())
    finally:
        ended.set()
        beats.join()
        site.close()


def _beat(site: SiteAttachment, ended: threading.Event) -> None:
    """Beat while a step waits for a busy disk: meanwhile the rings fill, and nothing is lost."""
    while not ended.wait(BEAT_S):
        site.beat(time.monotonic_ns())
