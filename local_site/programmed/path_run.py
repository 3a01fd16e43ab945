"""Runs on a path of the tool: each engagement a new one, from where the arm stands; pure."""

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array, angle_between
from common.messages.hand import OperatorSettings, TrackingStatus
from common.messages.requests import MappingDescription
from common.messages.robot import FOLLOWING, Engagement, GripperCommand, Pose, RobotState
from local_site.programmed.approach import approach, why_too_far
from local_site.programmed.led_hand import operator_T_hand, shown_hand, why_not_led
from local_site.programmed.path_progress import PathProgress, RunOrder
from local_site.tracking.tracker import ArmEstimate

BEHIND_M = 0.06  # fast motions lag by less
THERE_M, THERE_RAD = 0.02, np.radians(10.0)  # at rest; a hand that was taught may have pressed on beyond the arm
LONGEST_STEP_S = 0.1
TOGGLES_APART_NS = NS_PER_S  # until the remote site shows what became of one
WAITS = "waits for the engagement: press the key, and hold it"
ENDED = "the run has ended, since the arm held: let the key go, and hold it again for a new one"


class PathRun:
    """Turns a path into what a tracker would measure of the hand that leads the tool along it.

    A run begins with each engagement of this `session` for which the operator holds the key, with an approach from
    where the arm stands. While the arm holds it stands; with new origins after a hold it `goes_on` by a new approach,
    or else has ended. The end of the engagement, or of the key's being held, ends it in any case. `gripper_at_start` is
    how the gripper has to be before, None where that does not matter.
    """

    def __init__(
        self,
        progress: PathProgress,
        mapping: MappingDescription,
        session: int,
        gripper_at_start: GripperCommand | None,
        *,
        goes_on: bool,
    ) -> None:
        self._progress, self._mapping, self._session = progress, mapping, session
        self._gripper_at_start, self._goes_on = gripper_at_start, goes_on
        self._approach: PathProgress | None = None
        self._engagement = self._origin_ns = 0
        self._operator_T_hand = np.eye(4)
        self._last_ns, self._toggled_ns = 0, -TOGGLES_APART_NS
        self.toggles = 0

    def order(self, order: RunOrder) -> None:
        """Do what the operator orders of the run."""
        self._progress.order(order)

    def hand(self, now_ns: int, state: RobotState | None) -> ArmEstimate:
        """The hand of this instant; `state` is the remote site's newest, None while it is silent."""
        elapsed_s = min((now_ns - self._last_ns) / NS_PER_S, LONGEST_STEP_S)
        self._last_ns = now_ns
        if state is None:
            self._progress.stand()
            return self._shown(now_ns, "the remote site is silent")
        refusal = self._refusal(state)
        if refusal:
            self._progress.stand()
            return shown_hand(self._operator_T_hand, now_ns, TrackingStatus.INITIALISING, refusal)
        return self._shown(now_ns, self._lead(now_ns, elapsed_s, state))

    def _shown(self, now_ns: int, reason: str) -> ArmEstimate:
        return shown_hand(self._operator_T_hand, now_ns, TrackingStatus.TRACKED, reason)

    def _lead(self, now_ns: int, elapsed_s: float, state: RobotState) -> str:
        """Move the hand, if the arm follows it; what the run does, in words."""
        engagement, reference, target = state.engagement, state.reference, state.target
        is_ours = state.lease is not None and state.lease.session == self._session and state.readiness.held
        if engagement is None or not is_ours or state.state not in FOLLOWING:
            self._engagement = 0
            return WAITS
        led = reference is not None and reference.session == self._session
        if reference is None or target is None or not led or reference.rotation.operator_R_hand is None:
            self._progress.stand()
            return f"the run stands: {state.reason}"
        is_new = engagement.number != self._engagement
        if is_new:
            self._progress.begin()
        if is_new or engagement.hand_capture_ns != self._origin_ns:
            if not (is_new or self._goes_on):
                return ENDED
            if too_far := why_too_far(target.transform(), self._progress.target):
                return f"the run stands: {too_far}"
            self._set_out(engagement, target)
        base_T_target = self._advance(now_ns, elapsed_s, state)
        settings = state.settings or OperatorSettings()
        self._operator_T_hand = operator_T_hand(base_T_target, self._mapping, settings, reference)
        return self._in_words(state)

    def _set_out(self, engagement: Engagement, target: Pose) -> None:
        """Approach where the run stands from where the arm is led now."""
        self._engagement, self._origin_ns = engagement.number, engagement.hand_capture_ns
        self._progress.stand()
        self._approach = PathProgress(approach(target.transform(), self._progress.target), 1.0, stepwise=False)

    def _advance(self, now_ns: int, elapsed_s: float, state: RobotState) -> Array:
        """Advance the run; return where the tool is led to now (4 x 4), and toggle the gripper where that is due."""
        leading = self._approach or self._progress
        hindered = _hindered(leading, state)
        command = leading.advance(elapsed_s, state.gripper, hindered)
        if command is state.gripper_next and now_ns - self._toggled_ns >= TOGGLES_APART_NS:
            self.toggles, self._toggled_ns = self.toggles + 1, now_ns
        if self._approach is not None and self._approach.is_done:
            self._approach = None
        return leading.target

    def _in_words(self, state: RobotState) -> str:
        progress = self._progress
        if self._approach is not None:
            return self._approach.why or "approaches where the path goes on"
        if progress.is_done:
            off = _off(progress, state)
            return f"the run is done, but {off}" if off else "the run is done: let the key go"
        way_point = f", way point {progress.way_point} of {progress.way_points}" if progress.way_points else ""
        stands = f": {progress.why}" if progress.why else ""
        return f"runs at {progress.speed:.0%} speed{way_point}{stands}"

    def _refusal(self, state: RobotState) -> str:
        """Say why no run may begin or go on, with the cure; empty when it may."""
        locked = why_not_led(self._mapping, state.settings or OperatorSettings())
        if locked or self._engagement:
            return locked
        if state.gripper is None and (self._progress.grips or self._gripper_at_start is not None):
            return "the path needs a gripper, and this cell has none that is measured: its driver has to report one"
        if state.gripper_next is self._gripper_at_start:
            wanted = self._gripper_at_start.value
            return (
                f"the gripper differs: it has to be {wanted} at the beginning; end this, and make it so with "
                "'farhand local': engage, and open your hand for a moment"
            )
        return ""


def _hindered(leading: PathProgress, state: RobotState) -> str:
    """Say why the path stands, since the arm is not where it is led to; empty when it is near enough."""
    if leading.acts and (off := _off(leading, state)):
        return f"the gripper waits, {off}"
    way = float(np.linalg.norm(leading.target[:3, 3] - state.base_T_tool.transform()[:3, 3]))
    return f"the arm is {way * 1e3:.0f} mm behind: {state.reason}" if way > BEHIND_M else ""


def _off(leading: PathProgress, state: RobotState) -> str:
    """Say how far the arm is from where the path stands, and why; empty when it is there."""
    wanted, measured = leading.target, state.base_T_tool.transform()
    way = float(np.linalg.norm(wanted[:3, 3] - measured[:3, 3]))
    turn = angle_between(wanted[:3, :3], measured[:3, :3])
    if way <= THERE_M and turn <= THERE_RAD:
        return ""
    return f"the arm is {way * 1e3:.0f} mm and {np.degrees(turn):.0f} deg off: {state.reason}"
