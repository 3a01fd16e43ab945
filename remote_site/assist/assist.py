"""Fine adjustment: a state machine that offers a pose beside a marker and leads the tool there while asked; pure."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.hand import Intent
from common.messages.robot import AssistPhase, AssistState, AssistTarget, Pose
from remote_site.assist.config import AssistConfig, AssistTargetConfig
from remote_site.assist.leading import left_over, step_towards
from remote_site.assist.sighting import MarkerSighting
from remote_site.assist.standing_marker import StandingMarker
from remote_site.reasons import Code, Reason, reason

REACH_RAD = math.radians(20.0)
OWN_MOTION_M = 0.015
SHOWN_NS = 500 * NS_PER_MS  # how long the end stays to be read before the next offer
LONGEST_STEP_S = 0.1
DOWN = np.array([0.0, 0.0, -1.0])
THERE_M, THERE_RAD = 1e-3, math.radians(0.5)
BEGIN_NS = 600 * NS_PER_MS  # the tool may lag behind the hand when it begins
PATIENCE_NS = 1500 * NS_PER_MS
NEARER_M, NEARER_RAD = 1e-3, math.radians(0.5)
LAG_M, LAG_RAD = 0.02, math.radians(10.0)  # more than a slow robot's at the speeds of a lead

Way = tuple[float, float]  # m and rad
SILENT_NS = 200 * NS_PER_MS


class HeldKey:
    """The target for which the operator holds the key; after a silence only a press that follows a release counts."""

    def __init__(self) -> None:
        self._target: str | None = None
        self._pressed: str | None = None
        self._released = False
        self._heard_ns: int | None = None

    @property
    def held(self) -> bool:
        """Return whether the key is held, as far as that counts."""
        return self._target is not None

    def see(self, intent: Intent | None, now_ns: int) -> None:
        """Take a sample's intent, None where no page reported one."""
        if intent is None:
            self._forget()
            return
        self._heard_ns = now_ns
        target = intent.assist if self._released else None
        if target is not None and self._target is None:
            self._pressed = target
        if target is None or target != (self._target or target):
            self._pressed = target = None
        self._released = intent.assist is None or (self._released and target is not None)
        self._target = target

    def pressed(self) -> str | None:
        """The target that the key was pressed for since the last call, None without a press."""
        pressed, self._pressed = self._pressed, None
        return pressed

    def lapse(self, now_ns: int) -> int | None:
        """For how long nothing was reported, ns, once that is too long: the key no longer counts as held."""
        if self._heard_ns is None or now_ns - self._heard_ns <= SILENT_NS:
            return None
        silent_ns = now_ns - self._heard_ns
        self._forget()
        return silent_ns

    def _forget(self) -> None:
        self._target = self._pressed = self._heard_ns = None
        self._released = False


class LeadProgress:
    """Notices a tool that falls behind its target, or comes no nearer to its goal."""

    def __init__(self, since_ns: int) -> None:
        self._since_ns = self._nearer_ns = since_ns
        self._left: Way = (math.inf, math.inf)

    def is_stuck(self, left: Way, lag: Way, now_ns: int) -> bool:
        """Take how far the tool is from the goal and from its present target; whether to give up."""
        if left[0] < self._left[0] - NEARER_M or left[1] < self._left[1] - NEARER_RAD:
            self._left, self._nearer_ns = left, now_ns
        arrives = left[0] < NEARER_M and left[1] < NEARER_RAD
        behind = now_ns - self._since_ns > BEGIN_NS and (lag[0] > LAG_M or lag[1] > LAG_RAD)
        return behind or (not arrives and now_ns - self._nearer_ns > PATIENCE_NS)


@dataclass(frozen=True, slots=True)
class _Goal:
    """A target whose marker stands still, and the tool's pose there (4 x 4)."""

    target: AssistTargetConfig
    base_T_marker: Array
    base_T_tool: Array
    views: tuple[str, ...]

    @property
    def approach(self) -> Array:
        """The direction (3,) from which the tool comes last: along its own z to grasp, down to place."""
        return self.base_T_tool[:3, 2] if self.target.kind == "grasp" else DOWN


@dataclass(frozen=True, slots=True)
class _Lead:
    """The tool is led to a goal, since the hand was at `start` (3,) in m, by the sender's clock at `since_ns`."""

    goal: _Goal
    start: Array
    since_ns: int
    progress: LeadProgress


class Assist:
    """OFF <-> OFFERED -> LEADING -> ENDED -> OFF; time comes in as nanoseconds of this host's clock.

    Feed what is seen of the markers to `see`, every sample's intent to `observe_intent`, and call `step` once for each
    that is followed. Only a press of the key that names the offered target begins to lead; whatever ends it, the key
    has to be released first.
    """

    def __init__(self, config: AssistConfig) -> None:
        self._config = config
        self._markers = {number: StandingMarker(number) for number in config.marker_sizes_m}
        self._key = HeldKey()
        self._phase, self._why = AssistPhase.OFF, reason(Code.ASSIST_IDLE)
        self._lead: _Lead | None = None
        self._nearest: _Goal | None = None
        self._ended_ns = 0
        self._followed_ns: int | None = None
        self._base_T_tool: Array | None = None
        self._state: AssistState | None = None

    def see(self, sightings: Iterable[MarkerSighting]) -> None:
        """Take what the cameras know of the markers now."""
        for sighting in sightings:
            if sighting.marker in self._markers:
                self._markers[sighting.marker].see(sighting)

    def observe_intent(self, intent: Intent | None, now_ns: int) -> None:
        """Take what the operator's page reports with a sample; letting go ends the lead at once."""
        self._key.see(intent, now_ns)
        if self._lead is not None and not self._key.held:
            self._end(reason(Code.ASSIST_LET_GO), now_ns)

    def tick(self, now_ns: int) -> None:
        """End the lead when the page reports nothing any more, or the marker is no longer where it was."""
        silent_ns = self._key.lapse(now_ns)
        if self._lead is None:
            return
        if silent_ns is not None:
            self._end(reason(Code.ASSIST_SILENT, silent_ms=silent_ns / NS_PER_MS), now_ns)
            return
        goal = self._lead.goal
        lost = self._markers[goal.target.marker].strayed(goal.base_T_marker, now_ns)
        if lost is not None:
            self._end(reason(Code.ASSIST_LOST, cause=lost.sentence), now_ns)

    def halt(self, now_ns: int) -> None:
        """The arm does not follow: nothing is offered, and a lead ends."""
        self._followed_ns = None
        if self._lead is not None:
            self._end(reason(Code.ASSIST_HALTED), now_ns)
        elif self._phase is not AssistPhase.ENDED or now_ns - self._ended_ns > SHOWN_NS:
            self._state = None if self._nearest is not None or self._phase is not AssistPhase.OFF else self._state
            self._phase, self._why, self._nearest = AssistPhase.OFF, reason(Code.ASSIST_IDLE), None

    def step(
        self,
        hand_in_operator: Array,
        captured_ns: int,
        base_T_target: Array,
        base_T_tool: Array,
        now_ns: int,
        can_grasp: bool,
    ) -> Array | None:
        """The tool's next target (4 x 4) where it is led, None where the hand leads it.

        `base_T_target` is its present target, `base_T_tool` where it is measured; `captured_ns` is when the hand was
        at `hand_in_operator` (3,) m, by the sender's clock. A gripper that is closed already cannot grasp.
        """
        elapsed_s = (captured_ns - (self._followed_ns or captured_ns)) / NS_PER_S
        self._followed_ns, self._base_T_tool, self._state = captured_ns, base_T_tool, None
        if self._lead is None:
            self._offer(base_T_target, base_T_tool, now_ns, can_grasp)
            self._begin(hand_in_operator, captured_ns)
        if self._lead is None:
            return None
        moved_m = math.dist(hand_in_operator.tolist(), self._lead.start.tolist())
        if moved_m > OWN_MOTION_M:
            self._end(reason(Code.ASSIST_MOVED, distance_mm=1e3 * moved_m), now_ns)
            return None
        left, lag = left_over(base_T_tool, self._lead.goal.base_T_tool), left_over(base_T_tool, base_T_target)
        if self._lead.progress.is_stuck(left, lag, captured_ns):
            self._end(reason(Code.ASSIST_STUCK, distance_mm=1e3 * left[0], angle_deg=math.degrees(left[1])), now_ns)
            return None
        self._why = self._progress(self._lead.goal, left)
        led_s = (captured_ns - self._lead.since_ns) / NS_PER_S
        goal = self._lead.goal
        return step_towards(base_T_target, goal.base_T_tool, goal.approach, min(elapsed_s, LONGEST_STEP_S), led_s)

    def state(self) -> AssistState | None:
        """Return what the operator is shown; None where no targets are configured."""
        if self._state is None and self._config.targets:
            goal, tool = self._lead.goal if self._lead is not None else self._nearest, self._base_T_tool
            shown = self._shown(goal, tool) if goal is not None and tool is not None else None
            why = self._why
            self._state = AssistState(phase=self._phase, code=why.code.value, reason=why.sentence, target=shown)
        return self._state

    def _offer(self, base_T_target: Array, base_T_tool: Array, now_ns: int, can_grasp: bool) -> None:
        """Offer the nearest target in reach, or state what is missing; what has ended is shown first."""
        if self._phase is AssistPhase.ENDED and (self._key.held or now_ns - self._ended_ns < SHOWN_NS):
            return
        goals, refusals = self._goals(now_ns, can_grasp)
        poses = base_T_target, base_T_tool
        self._nearest = min(goals, key=lambda goal: _farthest(goal, poses)[0], default=None)
        if self._nearest is None:
            self._phase, self._why = AssistPhase.OFF, refusals[0] if refusals else reason(Code.ASSIST_IDLE)
            return
        distance_m, angle_rad = _farthest(self._nearest, poses)
        target, way = self._nearest.target, _words(distance_m, angle_rad)
        if distance_m <= 1e-3 * self._config.reach_mm and angle_rad <= REACH_RAD:
            self._phase = AssistPhase.OFFERED
            self._why = reason(Code.ASSIST_OFFERED, target=target.name, kind=target.kind, **way)
            return
        limits = {"limit_mm": self._config.reach_mm, "limit_deg": math.degrees(REACH_RAD)}
        self._phase, self._why = AssistPhase.OFF, reason(Code.ASSIST_FAR, target=target.name, **way, **limits)

    def _goals(self, now_ns: int, can_grasp: bool) -> tuple[list[_Goal], list[Reason]]:
        """The targets that make sense and whose markers stand still, and what is wrong with the others."""
        goals, refusals = [], []
        for target in self._config.targets:
            known = self._markers[target.marker].pose(now_ns)
            if isinstance(known, Reason):
                refusals.append(known)
            elif target.kind == "grasp" and not can_grasp:
                refusals.append(reason(Code.ASSIST_CLOSED, target=target.name))
            else:
                base_T_marker, views = known
                goals.append(_Goal(target, base_T_marker, base_T_marker @ target.marker_T_tool, views))
        return goals, refusals

    def _begin(self, hand_in_operator: Array, captured_ns: int) -> None:
        """Lead, if the key was just pressed for what is offered."""
        pressed, nearest = self._key.pressed(), self._nearest
        if self._phase is AssistPhase.OFFERED and nearest is not None and pressed == nearest.target.name:
            self._phase, self._lead = (
                AssistPhase.LEADING,
                _Lead(nearest, hand_in_operator.copy(), captured_ns, LeadProgress(captured_ns)),
            )

    def _progress(self, goal: _Goal, left: tuple[float, float]) -> Reason:
        distance_m, angle_rad = left
        there = distance_m < THERE_M and angle_rad < THERE_RAD
        code = Code.ASSIST_THERE if there else Code.ASSIST_LEADING
        return reason(code, target=goal.target.name, kind=goal.target.kind, **_words(distance_m, angle_rad))

    def _end(self, why: Reason, now_ns: int) -> None:
        self._phase, self._why, self._lead, self._ended_ns = AssistPhase.ENDED, why, None, now_ns
        self._state = None

    def _shown(self, goal: _Goal, base_T_tool: Array) -> AssistTarget:
        distance_m, angle_rad = left_over(base_T_tool, goal.base_T_tool)
        return AssistTarget(
            name=goal.target.name,
            kind=goal.target.kind,
            base_T_marker=Pose.from_transform(goal.base_T_marker),
            size=goal.target.size_m,
            base_T_tool=Pose.from_transform(goal.base_T_tool),
            distance_mm=1e3 * distance_m,
            angle_deg=math.degrees(angle_rad),
            views=goal.views,
        )


def _farthest(goal: _Goal, poses: Iterable[Array]) -> tuple[float, float]:
    """Compute how far the farthest of the tool's poses is from a goal, m and rad."""
    ways = [left_over(pose, goal.base_T_tool) for pose in poses]
    return max(way[0] for way in ways), max(way[1] for way in ways)


def _words(distance_m: float, angle_rad: float) -> dict[str, float]:
    return {"distance_mm": 1e3 * distance_m, "angle_deg": math.degrees(angle_rad)}
