"""The tool's target from accepted hand samples: mapping, the rest of a short hold, workspace box and leash; pure."""

import math

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, angle_between, pose_between
from common.messages.hand import OperatorSettings
from common.messages.robot import Engagement, MappingReference, Pose
from remote_site.kinematics.model import ArmModel
from remote_site.motion.config import ControlConfig
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.clearance import Workspace
from remote_site.session.samples import Accepted
from remote_site.teleop.config import MappingConfig
from remote_site.teleop.followed_orientation import FollowedOrientation
from remote_site.teleop.hold_offset import MOST_M, MOST_RAD, HoldOffset
from remote_site.teleop.mapping import make_mapping

EXACT = 1e-9  # m or rad: rounding is no lead
HALVINGS = 8  # of the way of one sample: what is left of it is less than anything that moves
LONGEST_STEP_S = 0.1  # between samples
LED_SPARE = 0.1  # of the catch-up speed: what a led target leaves of it
FELT_EXCESS_M = 0.002  # beyond the box: less is not told
MOST_PREDICTED_NS = 100 * NS_PER_MS  # of the way from exposure to arrival: a longer prediction overshoots
AGE_MEMORY = 1 / 30  # weight of the newest sample in the mean age
OFFSET_MEMORY = 1 / 300  # the same in the mean offset of the clocks
OFFSET_TRUST = 0.25  # of a measured offset's uncertainty: as far as the mean may be from it


class TargetTime:
    """Feed it every sample that is followed, in order."""

    def __init__(self) -> None:
        self._mean_age_ns: float | None = None
        self._mean_offset_ns: float | None = None

    def of(self, sample: Accepted, now_ns: int) -> int:
        """The time of the exposure, or later where a prediction from it would overshoot, ns."""
        captured_ns = self._captured_ns(sample)
        age_ns = now_ns - captured_ns
        mean_ns = age_ns if self._mean_age_ns is None else self._mean_age_ns
        self._mean_age_ns = mean_ns + AGE_MEMORY * (age_ns - mean_ns)
        return captured_ns + max(round(self._mean_age_ns) - MOST_PREDICTED_NS, 0)

    def _captured_ns(self, sample: Accepted) -> int:
        """The time of the exposure by the mean offset of the clocks.

        Where a link's delay varies, a measured offset is wrong by half of what the two ways differed: up to 20 ms at
        120 ms each way and a jitter of 20 %. With each measurement the hand would seem to jump in time.
        """
        stated_ns = sample.captured_ns - sample.sample.capture_ns
        mean_ns = stated_ns if self._mean_offset_ns is None else self._mean_offset_ns
        mean_ns += OFFSET_MEMORY * (stated_ns - mean_ns)
        trusted_ns = OFFSET_TRUST * (sample.captured_ns - sample.born_ns)
        self._mean_offset_ns = min(max(mean_ns, stated_ns - trusted_ns), stated_ns + trusted_ns)
        return sample.sample.capture_ns + round(self._mean_offset_ns)


class Leash:
    """Holds targets within `distance_m` and `angle_rad` of the tool, as sent and as measured, whichever allows less.

    A target is drawn towards the tool as it was sent, where the arm is led. What is measured only ever holds it back:
    a reading that is wrong but plausible cannot draw it away from the way between the target before and the wanted one.
    """

    def __init__(self, distance_m: float, angle_rad: float) -> None:
        self._distance_m, self._angle_rad = distance_m, angle_rad

    def hold(self, wanted: Array, former: Array, sent: Array, measured: Array) -> tuple[Array, Reason | None]:
        """The target for the `wanted` one, after the `former` one (all 4 x 4), and why where it is another."""
        target = self._drawn(wanted, sent)
        if not self._reaches(target, measured, measured):
            target = self._led_on(former, target, measured)
        if target is wanted:
            return wanted, None
        ahead_m, left_m = (max(_way(pose, arm)[0] for arm in (sent, measured)) for pose in (wanted, target))
        return target, reason(Code.SATURATED, distance_mm=1e3 * ahead_m, limit_mm=1e3 * left_m)

    def _drawn(self, wanted: Array, sent: Array) -> Array:
        """The wanted target drawn towards the tool as sent until it is within both limits."""
        distance, angle = _way(wanted, sent)
        within = self._distance_m / max(distance, self._distance_m), self._angle_rad / max(angle, self._angle_rad)
        return wanted if min(within) >= 1.0 else pose_between(sent, wanted, min(within))

    def _led_on(self, former: Array, target: Array, measured: Array) -> Array:
        """The last pose on the way to a target that is not farther from the measured tool than is allowed."""
        least, most = 0.0, 1.0
        for _ in range(HALVINGS):
            fraction = (least + most) / 2
            if self._reaches(pose_between(former, target, fraction), measured, former):
                least = fraction
            else:
                most = fraction
        return pose_between(former, target, least)

    def _reaches(self, target: Array, measured: Array, former: Array) -> bool:
        """Return whether a target is within both limits of the measured tool, or no farther from it than the former."""
        ways = zip(_way(target, measured), _way(former, measured), (self._distance_m, self._angle_rad), strict=True)
        return all(way <= max(before, limit) + EXACT for way, before, limit in ways)


def _way(a: Array, b: Array) -> tuple[float, float]:
    """The distance in m and the angle in rad between two poses (4 x 4)."""
    return math.dist(a[:3, 3].tolist(), b[:3, 3].tolist()), angle_between(a[:3, :3], b[:3, :3])


class ToolTarget:
    """The tool's target: `base_T_tool` (4 x 4), relative to both origins of the `engagement`.

    `reference` is what the next targets count from; None where that does not outlast a hold.
    """

    def __init__(
        self, mapping: MappingConfig, control: ControlConfig, box: Workspace, model: ArmModel, q: Array
    ) -> None:
        self._mapping = make_mapping(mapping)
        self._offset = HoldOffset()
        self._orientation = FollowedOrientation()
        self._followed: Accepted | None = None
        self._time = TargetTime()
        self._settings = OperatorSettings()
        self._leash = Leash(control.leash_m, math.radians(control.leash_deg))
        self._workspace = box
        self._model = model
        self.base_T_tool = model.forward(q)
        self.engagement: Engagement | None = None
        self.reference: MappingReference | None = None

    def bounded(self, settings: OperatorSettings) -> OperatorSettings:
        """The operator's settings within what is configured."""
        return self._mapping.bounded(settings)

    def measured(self, q: Array) -> Array:
        """The tool's pose (4 x 4) at the joints (n,) rad."""
        return self._model.forward(q)

    def capture(
        self, sample: Accepted, settings: OperatorSettings, q: Array, engagements: int, *, clutched: bool = False
    ) -> None:
        """Take both origins, the hand's from the sample and the tool's at `q` (n,) rad: earlier motion is discarded.

        After a hold of the same engagement, the `engagement` states how far this moves the target, unless the operator
        `clutched` to have it moved.
        """
        base_T_tool = self._model.forward(q)
        shift_mm, shift_deg = (0.0, 0.0) if clutched else self._shift(sample, base_T_tool, engagements)
        self.base_T_tool = base_T_tool
        self._mapping.steer(settings, sample.position, sample.operator_R_hand, base_T_tool)
        self._mapping.engage(sample.position, sample.operator_R_hand, base_T_tool)
        self._offset.clear()
        self._orientation.begin(sample.operator_R_hand)
        self._followed, self._settings = sample, settings
        pose = Pose.from_transform(base_T_tool)
        self.engagement = Engagement(engagements, sample.sample.capture_ns, pose, shift_mm, shift_deg)
        self.reference = self._mapping.reference(sample.sample, self._orientation.hand_R_followed)

    def resume(self, sample: Accepted, settings: OperatorSettings, q: Array, since_ns: int) -> bool:
        """Go on from `q` (n,) rad to the same origins after a hold since `since_ns`; False where new ones are due.

        They are where the hand went too far meanwhile, where too much is left to make up, or the settings are others.
        """
        if self.reference is None or settings != self._settings or self._strayed(sample, since_ns):
            return False
        base_T_tool, operator_R_hand = self._model.forward(q), self._orientation.resume(sample)
        if not self._offset.begin(self._mapping.target(sample.position, operator_R_hand), base_T_tool):
            return False
        self.base_T_tool, self._followed = base_T_tool, sample
        self.reference = self._mapping.reference(sample.sample, self._orientation.hand_R_followed)
        return True

    def aim(
        self, sample: Accepted, settings: OperatorSettings, q_sent: Array, q_measured: Array, now_ns: int
    ) -> ToolSample:
        """The target for the newest sample, inside the workspace box and within the leash from the arm (n,) rad.

        It counts from what was sent: what is measured can only hold it back.
        """
        position, elapsed_s = sample.position, self._elapsed_s(sample)
        if settings != self._settings:
            self._offset.clear()
            self._orientation.begin(sample.operator_R_hand)
        # the bounds are the tool's: a scale that enlarges the hand's rotation leaves the hand less of them
        operator_R_hand = self._orientation.follow(
            sample, elapsed_s / max(settings.rotation_scale, 1.0), self._offset.spare
        )
        self._mapping.steer(settings, position, operator_R_hand, self.base_T_tool)
        sent = self._model.forward(q_sent)
        self._mapping.read(sent)
        target = self._offset.apply(self._mapping.target(position, operator_R_hand), elapsed_s)
        self.reference = self._mapping.reference(sample.sample, self._orientation.hand_R_followed)
        self._settings = settings
        spare = max(self._offset.spare + self._orientation.spare - 1.0, 0.0)
        return self._bounded_sample(target, sent, self._model.forward(q_measured), sample, now_ns, spare)

    def lead(self, base_T_led: Array, sample: Accepted, q_sent: Array, q_measured: Array, now_ns: int) -> ToolSample:
        """The same for a target (4 x 4) that the hand does not choose; what it counts from is lost until `rebase`."""
        self.reference = None
        sent, measured = self._model.forward(q_sent), self._model.forward(q_measured)
        return self._bounded_sample(base_T_led.copy(), sent, measured, sample, now_ns, LED_SPARE)

    def rebase(self, sample: Accepted, settings: OperatorSettings) -> None:
        """Take both origins again, the tool's at its present target: the target does not move by it."""
        self._mapping.steer(settings, sample.position, sample.operator_R_hand, self.base_T_tool)
        self._mapping.engage(sample.position, sample.operator_R_hand, self.base_T_tool)
        self._offset.clear()
        self._orientation.begin(sample.operator_R_hand)
        self._settings = settings

    def _bounded_sample(
        self, target: Array, sent: Array, measured: Array, sample: Accepted, now_ns: int, spare: float
    ) -> ToolSample:
        """A target (4 x 4), which it may change, brought into the workspace box and within the leash."""
        boxed = self._boxed(target[:3, 3])
        target[:3, 3] = self._workspace.clamp(target[:3, 3])
        self.base_T_tool, leashed = self._leash.hold(target, self.base_T_tool, sent, measured)
        self._followed = sample
        elbow = self._mapping.elbow(sample.sample.wrist, sample.elbow)
        t_ns = self._time.of(sample, now_ns)
        return ToolSample(t_ns, now_ns, self.base_T_tool, elbow, leashed, spare=spare, boxed=boxed)

    def _boxed(self, wanted: Array) -> Reason | None:
        """Say why the box holds a target at a position (3,) that the hand asks for."""
        excess_m = self._workspace.excess(wanted)
        return reason(Code.OUTSIDE_BOX, excess_mm=1e3 * excess_m) if excess_m > FELT_EXCESS_M else None

    def _elapsed_s(self, sample: Accepted) -> float:
        """Between this sample and the one before it, by the sender's clock; a long gap counts as a short one."""
        last = self._followed
        elapsed_ns = sample.sample.capture_ns - last.sample.capture_ns if last is not None else 0
        return min(elapsed_ns / NS_PER_S, LONGEST_STEP_S)

    def _strayed(self, sample: Accepted, since_ns: int) -> bool:
        """Return whether the hand went too far from `since_ns` to this sample, if evenly since the last followed."""
        last = self._followed
        if last is None or sample.born_ns <= last.born_ns:
            return True
        fraction = min((sample.born_ns - since_ns) / (sample.born_ns - last.born_ns), 1.0)
        turned = 0.0
        if last.operator_R_hand is not None and sample.operator_R_hand is not None:
            turned = angle_between(last.operator_R_hand, sample.operator_R_hand)
        way = math.dist(last.position.tolist(), sample.position.tolist())
        return fraction * way > MOST_M or fraction * turned > MOST_RAD

    def _shift(self, sample: Accepted, base_T_tool: Array, engagements: int) -> tuple[float, float]:
        """Compute how far new origins move the target within an engagement, mm and deg."""
        if self.engagement is None or self.engagement.number != engagements:
            return 0.0, 0.0
        former = self._mapping.target(sample.position, sample.operator_R_hand)
        shift_m = math.dist(former[:3, 3].tolist(), base_T_tool[:3, 3].tolist())
        return 1e3 * shift_m, math.degrees(angle_between(former[:3, :3], base_T_tool[:3, :3]))
