"""The local site as a process: its links, children and cameras opened, its loop run until it is asked to stop."""

import secrets
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import cv2
import structlog

from common.cameras.lost_pictures import LostPictures
from common.errors import FarhandError
from common.host_clock import MonotonicClock
from common.link.channels import HAND, PREVIEW, STATE
from common.link.credentials import check_links
from common.link.endpoints import check_free
from common.link.transport import open_link
from common.messages.base import SESSION_BITS
from common.process.children import Children, Heartbeat
from common.process.log import LogFormat, log_end, start_log
from common.process.service import StopFlag, ask_for_real_time, notify
from local_site.acquisition.capture import Capture
from local_site.acquisition.rig_cameras import open_operator
from local_site.authority.lease_client import Authority
from local_site.authority.remote_watch import RemoteWatch
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig
from local_site.preview.preview import Preview, PreviewProcess
from local_site.runtime.loop import ArmTracking, LocalSite, SampleSender
from local_site.runtime.recorder_relay import RecorderRelay
from local_site.runtime.warm_up import warm_up

FIFO_PRIORITY = 20  # of tracking: below the robot's control, above everything that may come late


def run_local(
    config: LocalConfig,
    should_stop: StopFlag,
    save_views: Path | None = None,
    log_format: LogFormat = LogFormat.TEXT,
) -> None:
    """Run the local site until asked to stop; FarhandError when it cannot start or its cameras fail for good.

    `save_views` is a folder for the last annotated operator views, written as PNG at the end.
    """
    start_log("local", log_format)
    check_links((config.links.remote, config.links.listen), config.links, config.bearer)
    check_free(config.links.listen, config.links)
    children, lost = Children("local"), LostPictures(CAMERAS[: len(config.operator.sources)])
    if config.metrics.port:
        check_free(config.metrics.endpoint, config.links)
        children.start("metrics", partial(_metrics, config, lost), vital=False)
    try:
        _run(config, should_stop, save_views, lost)
    except FarhandError as error:
        structlog.get_logger().error("ending", reason=str(error))
        raise
    finally:
        children.end()
    log_end()


def _metrics(config: LocalConfig, lost: LostPictures, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    from common.process.metrics import run_metrics  # noqa: PLC0415  # imported only where figures are served
    from local_site.runtime.figures import LocalFigures  # noqa: PLC0415  # the same

    port, links, beat = config.metrics.port, config.links, heartbeat.beat
    operator, figures = config.authority.name, LocalFigures(lost)
    run_metrics(port, links.listen, HAND, config.cell, figures, should_stop, beat, links, operator=operator)


def _run(config: LocalConfig, should_stop: StopFlag, save_views: Path | None, lost: LostPictures) -> None:
    cv2.setNumThreads(1)
    warm_up(config.tracking)
    with ExitStack() as stack:
        site = _open_site(config, stack, lost)
        ask_for_real_time(FIFO_PRIORITY)
        notify("READY=1")
        structlog.get_logger().info("ready", cell=config.cell, remote=config.links.remote)
        try:
            while not should_stop():
                site.step()
                notify("WATCHDOG=1")
        finally:
            site.save_profile()
            site.log_summary()
        if save_views is not None:
            site.save_views(save_views)


def _open_site(config: LocalConfig, stack: ExitStack, lost: LostPictures) -> LocalSite:
    """Fork the children, open cameras and link, and connect them; the stack closes them, the link first."""
    clock, cell, links, wanted = MonotonicClock(), config.cell, config.links, config.authority
    operator = open_operator(config.operator, config.simulation, config.tracking, clock)
    drawing = PreviewProcess(config.preview, operator.rig.matrices)
    stack.callback(drawing.close)
    capture = Capture(operator.cameras, config.capture, clock, lost)
    stack.callback(capture.close)
    stack.callback(notify, "STOPPING=1")
    link = stack.enter_context(
        open_link(listen=(links.listen,), connect=(links.remote,), security=links, in_lanes=True)
    )
    session = secrets.randbits(SESSION_BITS)
    authority = stack.enter_context(Authority(link, cell, wanted.name, session, automatic=wanted.automatic))
    views = CAMERAS[: len(operator.cameras)]
    wires = {view: link.publisher(PREVIEW, cell, view, operator=wanted.name) for view in views}
    watch = RemoteWatch(link.latest(STATE, cell), session, operator.engaged)
    return LocalSite(
        capture,
        ArmTracking(config, operator, link),
        SampleSender(config, link, authority, watch, clock),
        watch,
        Preview(wires, drawing, config.preview.fps),
        RecorderRelay(config, link, authority),
        clock,
    )
