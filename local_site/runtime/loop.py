"""The local site's loop: views from the cameras, the arm tracked in them, hand samples sent."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import structlog

from common.cameras.images import write_image
from common.clock import NS_PER_MS, Clock
from common.errors import CameraError, MessageError
from common.link.channels import HAND, INTENT, JOINTS
from common.link.transport import Link
from common.messages.hand import FOUND, TrackingStatus
from common.process.log import RefusalLog, log_summary
from local_site.acquisition.capture import Capture
from local_site.acquisition.rig_cameras import OperatorRig
from local_site.authority.lease_client import Authority
from local_site.authority.remote_watch import RemoteWatch
from local_site.calibration.control_points import CAMERAS
from local_site.config import LocalConfig
from local_site.preview.preview import Preview
from local_site.runtime.joint_clicks import JointClicks
from local_site.runtime.profile_file import ProfileStore
from local_site.runtime.recorder_relay import RecorderRelay
from local_site.samples.hand_sample import HandSampler, IntentMerge, OpenHand, unless_in_force
from local_site.samples.smoothing import make_smoother
from local_site.tracking.annotate import annotate
from local_site.tracking.choice import make_tracker, profile_of
from local_site.tracking.drift import DriftWatch
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.tracker import ArmEstimate, Views


@dataclass(slots=True)
class SampleTally:
    """`seen` are those tracked or degraded, `oldest_ns` the longest of their times from exposure to sending."""

    sent: int = 0
    seen: int = 0
    oldest_ns: int = 0

    def note(self, status: TrackingStatus, age_ns: int) -> None:
        """Count a sample that was sent, this long after its exposure."""
        self.sent += 1
        if status in FOUND:
            self.seen += 1
            self.oldest_ns = max(self.oldest_ns, age_ns)

    def __str__(self) -> str:
        tracked = f"{self.seen / self.sent:.0%} tracked" if self.sent else "none tracked"
        return f"{self.sent} sent, {tracked}, the oldest {self.oldest_ns / NS_PER_MS:.0f} ms from exposure to sending"


class ArmTracking:
    """The tracker with what accompanies it: the operator's profile, the drift alarm, the console's joint clicks."""

    def __init__(self, config: LocalConfig, operator: OperatorRig, link: Link) -> None:
        name = config.authority.name
        self._profiles = ProfileStore(config.tracking.profile_dir, name, _warning("operator's profile"))
        self._tracker = make_tracker(operator.rig, operator.tracking, self._profiles.known)
        self._drift = DriftWatch(operator.rig, config.drift, _warning("drift"))
        refused = RefusalLog().note
        self._clicks = JointClicks(link.serve(JOINTS, config.cell, refused, operator=name), self._tracker)
        self._matrices = operator.rig.matrices
        self._seen: tuple[Views, ArmEstimate] | None = None

    def track(self, views: Views) -> ArmEstimate:
        """The arm in these views, with the drift alarm's sentence in its reason."""
        estimate = self._drift.judge(self._tracker.track(views))
        self._seen = views, estimate
        return estimate

    def attend(self, views: Views | None, now_ns: int) -> None:
        """Do what can wait until a sample is sent: answer a click on the joints, save the profile once a minute."""
        self._clicks.poll(views, now_ns)
        self._profiles.keep(self._learned, now_ns)

    def save_profile(self) -> None:
        """Save what has been learned of the operator, if a folder is configured."""
        self._profiles.save(self._learned)

    def save_views(self, folder: Path) -> bool:
        """Write the last views with what was found in them as operator_left.png, operator_right.png and so on.

        False without any view. CameraError if they cannot be written.
        """
        if self._seen is None:
            return False
        views, estimate = self._seen
        for k, view in enumerate(views.views):
            picture = annotate(view.current.image, estimate, k, self._matrices[k])
            write_image(folder, f"operator_{CAMERAS[k]}", picture)
        return True

    def _learned(self) -> OperatorProfile | None:
        return profile_of(self._tracker)


class SampleSender:
    """Sends estimates as hand samples, with the lease, the clocks' offset and the operator's intent of the instant."""

    def __init__(self, config: LocalConfig, link: Link, authority: Authority, watch: RemoteWatch, clock: Clock) -> None:
        self._authority, self._watch, self._clock = authority, watch, clock
        self._smoother = make_smoother(config.smoothing)
        self._gesture = config.gesture
        self._hand = OpenHand()
        self._sampler = HandSampler(authority.session)
        name = config.authority.name
        self._publisher = link.publisher(HAND, config.cell, operator=name)
        self._intents = link.latest(INTENT, config.cell, operator=name)
        self._intent = IntentMerge()
        self._refusals = RefusalLog("intent refused")

    def send_tracked(self, estimate: ArmEstimate, read_ns: int) -> None:
        """Count openings of the hand, smooth, send; `read_ns` is when the pictures were read."""
        self._hand = self._hand.observe(estimate, self._gesture)
        self._send(self._smoother.smooth(estimate), read_ns)

    def send_led(self, estimate: ArmEstimate, toggles: int) -> None:
        """Send the hand that leads the tool along a path, as it is, with the toggles of its gripper so far."""
        self._hand = OpenHand(toggles=toggles)
        self._send(estimate)

    def send_lost(self, reason: str) -> None:
        """Send a LOST sample with the reason why there are no views."""
        self._send(ArmEstimate(self._clock.now_ns(), TrackingStatus.LOST, reason))

    def _send(self, estimate: ArmEstimate, read_ns: int | None = None) -> None:
        now_ns = self._clock.now_ns()
        for _ in range(INTENT.depth):
            self._take_intent(now_ns)
        held = self._authority.lease_and_clock(now_ns, estimate.t_ns)
        intent = unless_in_force(self._intent.at(now_ns), self._watch.settings)
        self._publisher.put(self._sampler.sample(estimate, self._hand, held.lease, held.clock, intent, now_ns, read_ns))

    def _take_intent(self, now_ns: int) -> None:
        """Take one intent that waits, if there is one."""
        try:
            received = self._intents.take()
        except MessageError as error:
            self._refusals.note(error)
            return
        if received is not None:
            self._intent.receive(received, now_ns)


class LocalSite:
    """The loop's body: one instant from cameras to wire."""

    def __init__(
        self,
        capture: Capture,
        tracking: ArmTracking,
        sender: SampleSender,
        watch: RemoteWatch,
        preview: Preview,
        relay: RecorderRelay,
        clock: Clock,
    ) -> None:
        self._capture, self._tracking, self._sender = capture, tracking, sender
        self._relay = relay
        self._watch, self._preview, self._clock = watch, preview, clock
        self._status: TrackingStatus | None = None
        self._tally = SampleTally()

    def step(self) -> None:
        """Wait for the next views, track, smooth, send; without views, send why. CameraError once a camera ended.

        The preview comes last, in the time until the next views.
        """
        views = self._capture.next(self._capture.longest_wait_s)
        if views is not None:
            read_ns = self._clock.now_ns()
            estimate = self._tracking.track(views)
            self._sender.send_tracked(estimate, read_ns)
            self._tally.note(estimate.status, self._clock.now_ns() - estimate.t_ns)
            self._log_status(estimate.status, estimate.reason)
            self._watch.poll(self._clock.now_ns())
            self._preview.show(views, estimate)
        else:
            reason = self._capture.problem() or "no new views of the operator"
            self._sender.send_lost(reason)
            self._tally.note(TrackingStatus.LOST, 0)
            self._log_status(TrackingStatus.LOST, reason)
            if self._capture.ended:
                raise CameraError(reason)
            self._watch.poll(self._clock.now_ns())
            self._preview.show_reason(reason, self._clock.now_ns())
        self._relay.poll(self._clock.now_ns())
        self._tracking.attend(views, self._clock.now_ns())

    def save_profile(self) -> None:
        """Save what has been learned of the operator, if a folder is configured."""
        self._tracking.save_profile()

    def log_summary(self) -> None:
        """Log what the run was like."""
        log_summary({**self._watch.summary.sentences(), "samples": str(self._tally)})

    def save_views(self, folder: Path) -> None:
        """Write the last views, annotated, into a folder; a warning without any, CameraError if it cannot write."""
        if not self._tracking.save_views(folder):
            structlog.get_logger().warning("no views to save", reason=self._capture.problem() or "none came in time")

    def _log_status(self, status: TrackingStatus, reason: str) -> None:
        if status is not self._status:
            self._status = status
            structlog.get_logger().info("tracking", status=status.value, reason=reason)


def _warning(event: str) -> Callable[[str], None]:
    """Return a function that logs a sentence as the reason of this event."""

    def warn(sentence: str) -> None:
        structlog.get_logger().warning(event, reason=sentence)

    return warn
