"""The remote site: starts control, video and, where it is simulated, the cell; ends all when one dies."""

import time
from contextlib import ExitStack
from functools import partial

import msgspec
import structlog

from common.errors import FarhandError, ProcessError
from common.geometry import Array
from common.host_clock import MonotonicClock, host_time
from common.link.channels import CAMERA, KEY_FRAMES, SHOWN, STATE, ChannelSession
from common.link.config import NAME_OPERATORS
from common.link.credentials import CertificateValidity, check_links, check_viewers
from common.link.endpoints import check_free
from common.link.pubsub import Publisher
from common.link.roles import Identity, Role
from common.link.session_settings import PICTURES_SEND_BUFFER_BYTES
from common.link.tap import untapped
from common.link.viewers import Site
from common.messages.video import VideoFrame
from common.process.children import READY_TIMEOUT_S, Children, Heartbeat
from common.process.log import LogFormat, log_end, log_summary, start_log
from common.process.service import StopFlag, notify
from common.process.viewers import run_viewers
from common.steady_time import OwnReadings
from remote_site.config import RemoteConfig
from remote_site.drivers.memory import DriverMemory
from remote_site.kinematics.limits import load_arm
from remote_site.link_config import VIEWERS_TABLE
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.memory_files import memory_place
from remote_site.recording.taps import VideoTap
from remote_site.runtime.assist_memory import AssistMemory
from remote_site.runtime.checks import check_robot, say_what_is_not_guarded
from remote_site.runtime.control import run_control
from remote_site.runtime.crash_marker import CrashMarker
from remote_site.runtime.driver_process import run_driver
from remote_site.runtime.emulated_robot import REAL_ROBOT, start_robot, unused_address
from remote_site.runtime.links import open_site_link
from remote_site.runtime.site_memory import SiteMemory
from remote_site.session.config import EngagementMode
from remote_site.simulation.memory import CellMemory
from remote_site.video.calibration import calibration_of
from remote_site.video.full_pictures import FullPictures
from remote_site.video.marker_look import MarkerLook
from remote_site.video.process import VideoTally, VideoWire, run_video
from remote_site.video.sources import SimulatedViews

CHECK_S = 0.1
CHECKS_PER_VALIDITY = 10


def run_remote(config: RemoteConfig, should_stop: StopFlag, log_format: LogFormat = LogFormat.TEXT) -> None:
    """Run the remote site until asked to stop; ProcessError when one of its processes dies or hangs.

    Nothing engages before all processes have started. Only an orderly end removes the marker of an unfinished run."""
    start_log("remote", log_format)
    log = structlog.get_logger()
    _check_start(config)
    marker = CrashMarker(config.cell)
    unfinished = marker.set()
    if unfinished and config.engagement.mode is EngagementMode.AUTOMATIC:
        log.warning("the last run did not end in order: nothing engages automatically", cure="farhand engage")
        config = config.engaging(EngagementMode.ON_REQUEST)
    children, stack, site = Children("remote"), ExitStack(), SiteMemory()
    try:
        _start_children(config, children, stack, site)
        children.wait_ready(READY_TIMEOUT_S, should_stop)
        if not should_stop():
            site.set_ready()
            notify("READY=1")
            log.info("ready", cell=config.cell, driver=config.driver.name, control=config.links.control_endpoint)
        _watch(children, CertificateValidity(config.links.tls), should_stop)
        site.set_ending()
        marker.clear()
    except FarhandError as error:
        site.set_failure(str(error))
        log.error("ending", reason=str(error))
        raise
    finally:
        notify("STOPPING=1")
        children.end()
        stack.close()
    log_end()


def _start_children(config: RemoteConfig, children: Children, stack: ExitStack, site: SiteMemory) -> None:
    """Fork every process of the site; what has to be removed after they have ended goes on the stack."""
    simulated = config.cell_is_simulated or config.views_are_simulated
    memory = CellMemory.create(len(config.robot.start_deg)) if simulated else None
    driver_memory = DriverMemory.create(len(config.robot.start_deg))
    config, _ = start_robot(config, children)
    if memory is not None and config.cell_is_simulated:
        children.start("cell", partial(run_cell_child, config, memory))
    children.start("driver", partial(run_driver, config, driver_memory, memory))
    tally = VideoTally([camera.name for camera in config.video.cameras])
    stack.callback(lambda: log_summary(tally.sentences()))
    assist = _assist_memory(config)
    recording = _recording_memory(config)
    if recording is not None:
        stack.callback(recording.remove)
    children.start("video", partial(_video, config, memory, tally, site, assist, recording))
    children.start("control", partial(run_control, config, driver_memory, memory, site, assist, recording))
    if config.metrics.port:
        children.start("metrics", partial(_metrics, config, tally), vital=False)
    if config.links.viewers.listen:
        seen = Site(config.cell, config.links.listened, config.links)
        children.start("viewers", partial(run_viewers, config.links.viewers, VIEWERS_TABLE, seen), vital=False)


def _check_start(config: RemoteConfig) -> None:
    """FarhandError for what would otherwise fail later, in a process of the site."""
    links, served = config.links, (config.metrics.endpoint,) if config.metrics.port else ()
    bearer = Identity(Role.REMOTE, config.cell)
    check_links(links.endpoints, links, bearer)
    check_viewers(links.viewers, links.tls, bearer, VIEWERS_TABLE)
    for endpoint in (*links.listened, *served):
        check_free(endpoint, links)
    if links.viewers.listen:
        check_free(links.viewers.listen, links.viewers.security)
    if not links.heard:
        structlog.get_logger().warning("nobody may operate: links.operators is empty", cure=NAME_OPERATORS)
    check_robot(config)
    say_what_is_not_guarded(config)
    if unused := unused_address(config.driver):
        structlog.get_logger().warning("the robot is emulated", unused=unused, cure=REAL_ROBOT)


def _watch(children: Children, validity: CertificateValidity, should_stop: StopFlag) -> None:
    """Return when asked to stop; FarhandError when a process fails, or the site's certificate expires."""
    checks = 0
    while not should_stop.wait(CHECK_S):
        children.check()
        checks += 1
        if checks % CHECKS_PER_VALIDITY == 0:
            validity.check()
        notify("WATCHDOG=1")


def run_cell_child(config: RemoteConfig, memory: CellMemory, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    """The process of the simulated cell."""
    from remote_site.simulation.process import SimulatedCell, run_cell  # noqa: PLC0415  # a real cell needs no MuJoCo

    run_cell(SimulatedCell(config.simulation, config.robot, memory), should_stop, heartbeat.beat)


def _video(
    config: RemoteConfig,
    memory: CellMemory | None,
    tally: VideoTally,
    site: SiteMemory,
    assist: AssistMemory | None,
    recording: RecordingMemory | None,
    should_stop: StopFlag,
    heartbeat: Heartbeat,
) -> None:
    tap = VideoTap(recording, config.cell, MonotonicClock()) if recording is not None else None
    note_message = tap.note_message if tap is not None else untapped
    views = SimulatedViews(config.simulation, config.robot, memory) if memory is not None else None
    with open_site_link(
        config.links, ChannelSession.VIDEO, should_stop, PICTURES_SEND_BUFFER_BYTES, note_message
    ) as link:
        publishers: dict[str, Publisher[VideoFrame]] = {
            camera.name: link.publisher(CAMERA, config.cell, camera.name) for camera in config.video.cameras
        }

        readings = OwnReadings()
        readings.note(host_time())

        def publish(frame: VideoFrame) -> None:
            readings.note(host_time())
            ahead_ns = readings.least_ahead_ns(frame.capture_ns)
            publishers[frame.camera].put(msgspec.structs.replace(frame, ahead_ns=ahead_ns))
            tally.note(frame, time.monotonic_ns())

        shown = [link.latest(SHOWN, config.cell, operator=name).take_named for name in config.links.heard]
        key_frames = link.latest(KEY_FRAMES, config.cell).take

        def has_listener() -> bool:
            return any(publisher.has_listener for publisher in publishers.values())

        queues = link.send_queues()

        def unsent_bytes() -> int:
            lease = site.lease
            holder = Identity(Role.OPERATOR, config.cell, lease.holder) if lease is not None else None
            return queues.unsent_bytes(holder.common_name if holder is not None else "")

        wire = VideoWire(
            publish, shown, lambda: site.lease, key_frames, site.show_video_link, has_listener, unsent_bytes
        )
        look = _marker_look(config, assist) if assist is not None else None
        full = FullPictures(config.video, tap) if tap is not None else None
        run_video(config.video, views, wire, should_stop, heartbeat.beat, look, full, tally.lost)


def _assist_memory(config: RemoteConfig) -> AssistMemory | None:
    return AssistMemory(config.assist, len(config.robot.start_deg)) if config.assist.targets else None


def _recording_memory(config: RemoteConfig) -> RecordingMemory | None:
    """Make what a recorder attaches to; None, with the reason in the log, where that fails: nothing else needs it."""
    try:
        return RecordingMemory.create(memory_place(config.cell, config.links), time.monotonic_ns())
    except ProcessError as error:
        structlog.get_logger().error("no recording", reason=str(error))
        return None


def _marker_look(config: RemoteConfig, assist: AssistMemory) -> MarkerLook:
    """Make what looks for the markers of the targets in all views that are calibrated."""
    video, cell, tool_T_tcp = config.video, config.simulation, config.robot.tool_T_tcp
    known = {camera.name: calibration_of(camera, video, cell, tool_T_tcp) for camera in video.cameras}
    views = {name: calibration for name, calibration in known.items() if calibration is not None}
    model, _ = load_arm(config.robot)

    def tool_at(t_ns: int) -> Array | None:
        q = assist.joints_at(t_ns)
        return model.forward(q) if q is not None else None

    return MarkerLook(config.assist, views, tool_at, assist.show_markers, MonotonicClock())


def _metrics(config: RemoteConfig, tally: VideoTally, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    from common.process.metrics import run_metrics  # noqa: PLC0415  # loaded only where figures are requested
    from remote_site.runtime.figures import RemoteFigures  # noqa: PLC0415  # the same

    port, figures = config.metrics.port, RemoteFigures(tally)
    links, beat = config.links, heartbeat.beat
    run_metrics(port, links.control_endpoint, STATE, config.cell, figures, should_stop, beat, links)
