"""The process of the local site's recorder: steps until it is asked to stop, then ends the recording in order."""

import time
from collections.abc import Callable
from datetime import datetime

import structlog

from common.link.channels import RECORDER
from common.link.credentials import check_links
from common.process.service import StopFlag, notify
from common.recording.guarded import GuardedRecording
from common.recording.session import RecordingPlan
from local_site.config import LocalConfig
from local_site.recording.recorder import OperatorRecorder
from local_site.recording.source import OperatorSource

POLL_S = 0.05


def record_operator(
    config: LocalConfig, plan: RecordingPlan, date: Callable[[], datetime], should_stop: StopFlag
) -> None:
    """Record what passes the local site's links until asked to stop; FarhandError where they cannot be opened."""
    check_links((config.links.remote, config.links.listen), config.links, config.bearer)
    with OperatorSource(config) as source:
        notices = source.link.publisher(RECORDER, config.cell, operator=config.authority.name)
        recorder = OperatorRecorder(config, GuardedRecording(plan, date), source)
        notify("READY=1")
        structlog.get_logger().info("ready", cell=config.cell)
        while not should_stop():
            notice = recorder.step(time.monotonic_ns())
            if notice is not None:
                notices.put(notice)
            notify("WATCHDOG=1")
            should_stop.wait(POLL_S)
        notify("STOPPING=1")
        recorder.end(time.monotonic_ns())
