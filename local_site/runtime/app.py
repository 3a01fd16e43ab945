"""The local site: cameras, tracking, smoothing and publishing in one loop; wiring only."""

import secrets
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import structlog

from common.cameras.camera import Camera
from common.clock import Clock, MonotonicClock
from common.errors import CameraError, FarhandError, MessageError
from common.link.channels import (
    HAND,
    INTENT,
    JOINTS,
    PREVIEW,
    STATE,
)
from common.link.credentials import check_links
from common.link.endpoints import check_free
from common.link.roles import Identity, Role
from common.link.transport import Link, open_link
from common.messages.hand import TrackingStatus
from common.process.children import Children, Heartbeat
from common.process.log import LogFormat, RefusalLog, start_log
from common.process.service import StopFlag, ask_for_real_time, notify
from local_site.acquisition.capture import Capture
from local_site.acquisition.rig_cameras import of_one_camera, open_rig_cameras
from local_site.authority.lease_client import Authority
from local_site.authority.remote_watch import RemoteWatch
from local_site.calibration.control_points import CAMERAS
from local_site.calibration.rig import Rig
from local_site.calibration.rig_file import load_rig
from local_site.config import LocalConfig
from local_site.preview.picture_files import write_picture
from local_site.preview.preview import Preview
from local_site.preview.process import PreviewProcess
from local_site.runtime.joint_clicks import JointClicks
from local_site.runtime.profile_file import ProfileKeeper
from local_site.runtime.warm_up import warm_up
from local_site.samples.gesture import OpenHand, observe
from local_site.samples.intent import IntentMerge
from local_site.samples.publisher import HandPublisher
from local_site.samples.smoothing import make_smoother
from local_site.simulation.calibrated import calibrate_simulated
from local_site.simulation.source import SimulatedCameras
from local_site.tracking.annotate import annotate
from local_site.tracking.choice import TrackingConfig, make_tracker, profile_of
from local_site.tracking.drift import DriftWatch
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.tracker import ArmEstimate, Views

VIEWS_TIMEOUT_S = 0.1
SESSION_BITS = 62
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
    check_links((config.links.remote, config.links.listen), config.links, Identity(Role.OPERATOR, config.cell))
    check_free(config.links.listen, config.links)
    children = Children("local")
    if config.metrics.port:
        check_free(config.metrics.endpoint, config.links)
        children.start("metrics", partial(_metrics, config), vital=False)
    try:
        _run(config, should_stop, save_views)
    finally:
        children.end()


def _run(config: LocalConfig, should_stop: StopFlag, save_views: Path | None) -> None:
    clock = MonotonicClock()
    cv2.setNumThreads(1)
    warm_up(config.tracking)
    try:
        operator = _open_operator(config)
        drawing = PreviewProcess(config.preview, operator.rig.matrices)
        capture = Capture(operator.cameras, config.capture, clock)
        try:
            session = secrets.randbits(SESSION_BITS)
            wanted, links = config.authority, config.links
            with (
                open_link(listen=(links.listen,), connect=(links.remote,), security=links) as link,
                Authority(link, config.cell, wanted.name, session, automatic=wanted.automatic) as authority,
            ):
                wires = {name: link.publisher(PREVIEW, config.cell, name) for name in CAMERAS[: len(operator.cameras)]}
                preview = Preview(wires, drawing, config.preview.fps)
                site = LocalSite(config, operator, capture, link, authority, preview, clock)
                ask_for_real_time(FIFO_PRIORITY)
                notify("READY=1")
                structlog.get_logger().info("ready", cell=config.cell, remote=config.links.remote)
                try:
                    while not should_stop():
                        site.step()
                        notify("WATCHDOG=1")
                finally:
                    site.keep_profile()
                if save_views is not None:
                    site.save_views(save_views)
        finally:
            notify("STOPPING=1")
            drawing.close()
            capture.close()
    except FarhandError as error:
        structlog.get_logger().error("ending", reason=str(error))
        raise


def _metrics(config: LocalConfig, should_stop: StopFlag, heartbeat: Heartbeat) -> None:
    from common.process.metrics import run_metrics  # noqa: PLC0415  # only who asks for figures waits for it
    from local_site.runtime.figures import LocalFigures  # noqa: PLC0415  # the same

    port, links, beat = config.metrics.port, config.links, heartbeat.beat
    run_metrics(port, links.listen, HAND, config.cell, LocalFigures(), should_stop, beat, links)


@dataclass(frozen=True, slots=True)
class OperatorRig:
    """The cameras that see the operator, their calibration and tracker; who is told that the arm is engaged (ns)."""

    rig: Rig
    tracking: TrackingConfig
    cameras: Sequence[Camera]
    engaged: Callable[[int], None]


def _open_operator(config: LocalConfig) -> OperatorRig:
    operator = config.operator
    if operator.is_simulated:
        simulated = SimulatedCameras(config.simulation)
        rig = simulated.rig if config.simulation.textured else calibrate_simulated(config.simulation)
        return OperatorRig(rig, config.tracking, simulated.cameras, simulated.begin)
    rig, tracking = load_rig(Path(operator.rig)), config.tracking
    if operator.alone:
        rig, tracking = of_one_camera(rig, tracking)
    cameras = open_rig_cameras(rig, operator.sources, operator.fps, operator.latency_ms)
    return OperatorRig(rig, tracking, cameras, lambda _t_ns: None)


def _warn_of_drift(sentence: str) -> None:
    structlog.get_logger().warning("drift", reason=sentence)


def _warn_of_profile(sentence: str) -> None:
    structlog.get_logger().warning("operator's profile", reason=sentence)


@dataclass(frozen=True, slots=True)
class Seen:
    """The last views with what was found in them."""

    views: Views
    estimate: ArmEstimate


class LocalSite:
    """The loop's body: one instant from cameras to wire."""

    def __init__(
        self,
        config: LocalConfig,
        operator: OperatorRig,
        capture: Capture,
        link: Link,
        authority: Authority,
        preview: Preview,
        clock: Clock,
    ) -> None:
        self._capture = capture
        self._authority = authority
        self._preview = preview
        self._clock = clock
        self._profiles = ProfileKeeper(config.tracking.profile_dir, config.authority.name, _warn_of_profile)
        self._tracker = make_tracker(operator.rig, operator.tracking, self._profiles.known)
        name = config.authority.name
        refused = RefusalLog().note
        self._clicks = JointClicks(link.serve(JOINTS, config.cell, refused, name), self._tracker)
        self._drift = DriftWatch(operator.rig, config.drift, _warn_of_drift)
        self._smoother = make_smoother(config.smoothing)
        self._hold_ms = config.gesture.hold_ms
        self._hand = OpenHand()
        self._matrices = operator.rig.matrices
        self._publisher = HandPublisher(link.publisher(HAND, config.cell), authority.session)
        self._intents = link.latest(INTENT, config.cell, config.authority.name)
        self._intent = IntentMerge()
        self._refusals = RefusalLog("intent refused")
        self._watch = RemoteWatch(link.latest(STATE, config.cell), authority.session, operator.engaged)
        self._status: TrackingStatus | None = None
        self._seen: Seen | None = None

    def step(self) -> None:
        """Wait for the next views, track, smooth, publish; without views, say why. CameraError once a camera ended.

        The preview comes last, in the time until the next views.
        """
        views = self._capture.next(VIEWS_TIMEOUT_S)
        if views is not None:
            estimate = self._publish(views)
            self._watch.look(self._clock.now_ns())
            self._preview.show(views, estimate)
        else:
            reason = self._capture.problem() or "no new views of the operator"
            self._publish_nothing_seen(reason)
            self._watch.look(self._clock.now_ns())
            self._preview.say(reason, self._clock.now_ns())
        self._clicks.poll(views, self._clock.now_ns())
        self._profiles.keep(self._learned, self._clock.now_ns())

    def keep_profile(self) -> None:
        """Save what has been learned of the operator, where it is to be kept."""
        self._profiles.save(self._learned)

    def _learned(self) -> OperatorProfile | None:
        return profile_of(self._tracker)

    def _publish(self, views: Views) -> ArmEstimate:
        estimate = self._drift.judge(self._tracker.track(views))
        open_now = estimate.hand_open if estimate.wrist is not None else None
        self._hand = observe(self._hand, open_now, views.t_ns, self._hold_ms)
        self._send(self._smoother.smooth(estimate))
        self._seen = Seen(views, estimate)
        self._tell(estimate.status, estimate.reason)
        return estimate

    def _publish_nothing_seen(self, reason: str) -> None:
        self._send(ArmEstimate(self._clock.now_ns(), TrackingStatus.LOST, reason))
        self._tell(TrackingStatus.LOST, reason)
        if self._capture.ended:
            raise CameraError(reason)

    def _send(self, estimate: ArmEstimate) -> None:
        """Publish an estimate with what holds now: the lease, the clocks, the operator's intent."""
        now_ns = self._clock.now_ns()
        try:
            told = self._intents.take()
        except MessageError as error:
            self._refusals.note(error)
        else:
            if told is not None:
                self._intent.hear(told, now_ns)
        self._publisher.publish(estimate, self._hand, self._authority.standing(now_ns), self._intent.at(now_ns))

    def _tell(self, status: TrackingStatus, reason: str) -> None:
        if status is not self._status:
            self._status = status
            structlog.get_logger().info("tracking", status=status.value, reason=reason)

    def save_views(self, folder: Path) -> None:
        """Write the last views with what was found in them as operator_left.png, operator_right.png and so on.

        CameraError if they cannot be written; without any view, it is said and nothing is written.
        """
        if self._seen is None:
            structlog.get_logger().warning("no views to save", reason=self._capture.problem() or "none came in time")
            return
        for k, view in enumerate(self._seen.views.views):
            picture = annotate(view.current.image, self._seen.estimate, k, self._matrices[k])
            write_picture(folder, f"operator_{CAMERAS[k]}", picture)
