"""The scripted visual operator: looks at the page, decides, and moves a hand and a key; it is no person."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_S
from common.geometry import Array, vector_from_rotation
from common.messages.hand import Intent, Locks, OperatorSettings
from common.messages.requests import MappingDescription
from common.messages.robot import GripperStatus, SessionState
from lab.visual_operator.assist_key import AssistKey, Led
from lab.visual_operator.hand import ScriptedHand
from lab.visual_operator.shown import ShownPage
from lab.visual_operator.sight.sight import Scene
from lab.visual_operator.stages import PLACE, Act, Course, Moves
from lab.visual_operator.steering import Steering, begin_of, within_room
from lab.visual_operator.task import PlacingTask

SETTLE_S, LAG_S = 0.25, 0.2  # after a movement, until the arm rests; at least by how much it lags without a network
GRIP_S = 2.5
OPENED_S = 0.9
REST_S = 1.0
PATIENCE_S = 4.0
MOST_TILT, FALLEN = np.radians(5), np.radians(30)
GOOD_M, GOOD_RAD = 0.004, np.radians(3.0)
MOST_TRIES = 3
STUCK = frozenset({"out_of_reach", "saturated", "obstacle", "position"})  # the arm cannot follow to where the hand is

See = Callable[[ShownPage], Scene]  # what is on a page: the sight, or what stands for it


@dataclass
class Notes:
    """A record of what the operator did: steps with their times (s), clutches, grasps that missed, placings judged."""

    steps: list[tuple[float, str]] = field(default_factory=list)
    clutches: int = 0
    misses: int = 0
    tries: int = 0
    gave_up: bool = False


@dataclass
class _Timing:
    """The times at which the operator goes on, s: pictures from before `look_s` tell nothing; it presses at `press_s`.

    The gripper should have done what was asked of it by `gripped_s`. None: there is nothing to wait for. An arm rests
    `settle_s` after the hand.
    """

    look_s: float = REST_S
    press_s: float | None = REST_S
    gripped_s: float | None = None
    settle_s: float = SETTLE_S


class VisualOperator:
    """Sees one page after the other (`look`); `hand` is its hand's path, `intent` its key and settings.

    Times are s since the hand's start. Nothing but the page, by `see`, the cell's mapping and the task is known to it.
    One that does not see how the block in the gripper is turned trusts its hand.
    """

    def __init__(
        self,
        task: PlacingTask,
        see: See,
        mapping: MappingDescription,
        hand: ScriptedHand,
        locks: Locks,
        sees_turn: bool = True,
    ) -> None:
        self._task, self._see, self.hand = task, see, hand
        self._steering = Steering(mapping, locks.roll, sees_turn)
        self._settings = OperatorSettings(lease=1, revision=1, locks=locks)
        self.intent = Intent(hold=False, settings=self._settings)
        self._course, self._timing = Course(), _Timing()
        self._scene: Scene | None = None
        self._assist = AssistKey(hand.motor.reaction_s)
        self.notes = Notes()
        self.done = False

    def look(self, shown: ShownPage, start_ns: int) -> None:
        """Take a page, whose times are ns, the hand's start among them; what is decided follows after the reaction."""
        now_s = (shown.t_ns - start_ns) / NS_PER_S
        self._scene = scene = self._see(shown)
        timing = self._timing
        timing.settle_s = max(SETTLE_S, LAG_S + shown.delay_s)
        if timing.press_s is not None:
            self._press(now_s)
        elif shown.state is not SessionState.ENGAGED:
            self._wait_for_arm(now_s)
        elif timing.gripped_s is not None:
            self._watch_gripper(shown, now_s)
        elif self._course.holding and shown.gripper is GripperStatus.CLOSED:
            self._grasp_again(now_s)  # the block has slipped out
        elif (scene.t_ns - start_ns) / NS_PER_S >= timing.look_s:
            self._go_about(shown, scene, now_s)
        self.intent = replace(self.intent, assist=self._assist.held)

    def _press(self, now_s: float) -> None:
        timing = self._timing
        if timing.press_s is not None and now_s >= timing.press_s:
            self.intent = replace(self.intent, hold=True)
            timing.press_s, timing.look_s = None, now_s + timing.settle_s

    def _wait_for_arm(self, now_s: float) -> None:
        """Let the site take the arm up again by itself; after a while let go of the key, and press it again."""
        if now_s - self._timing.look_s > PATIENCE_S:
            self._clutch(np.zeros(3), now_s)

    def _go_about(self, shown: ShownPage, scene: Scene, now_s: float) -> None:
        """Let the robot bring the tool to the step's goal where it offers to, or else do it by hand."""
        start_s = now_s + self.hand.motor.reaction_s
        led = self._assist.see(shown.assist, self._course.stage.assist, now_s)
        if led is Led.BY_HAND:
            self._decide(scene, shown.code in STUCK, start_s)
        elif led is Led.THERE:
            self._act(start_s)

    def _decide(self, scene: Scene, stuck: bool, start_s: float) -> None:
        """Move towards the step's goal, or go on to the next once it is reached."""
        if not self._course.holding and _fallen(scene):
            self._finish(gave_up=True)
            return
        stage = self._course.stage
        moved = scene.block if stage.moves is Moves.BLOCK else scene.gripper
        goal = stage.goal(self._task, scene)
        if goal is None or moved is None:
            return
        moved = self._steering.believed(moved, held=stage.moves is Moves.BLOCK)
        gripper = self._task.grasp_of(moved) if stage.moves is Moves.BLOCK else moved
        apart_m, apart_rad = _apart(goal, moved)
        apart_rad = self._steering.possible_turn(apart_rad, gripper)  # what the locks forbid cannot be waited for
        turned, tilted = abs(float(apart_rad[2])), float(np.hypot(*apart_rad[:2]))
        near = float(np.linalg.norm(apart_m)) <= stage.within_m
        if self._course.seen(near and turned <= stage.within_rad and tilted <= MOST_TILT):
            self._act(start_s)
        elif not near or turned > stage.within_rad or tilted > MOST_TILT:
            self._correct(goal, moved, gripper, stuck, start_s)

    def _correct(self, goal: Array, moved: Array, gripper: Array, stuck: bool, start_s: float) -> None:
        movement = self._steering.towards(goal, moved, gripper, self._settings)
        possible = within_room(*self.hand.aim(), movement)
        if possible is None or stuck:
            self._clutch(movement.shift, start_s)
        else:
            self._steering.begin(possible, self._settings)
            self._timing.look_s = self.hand.move(start_s, possible.shift, possible.turn) + self._timing.settle_s

    def _clutch(self, shift: Array, start_s: float) -> None:
        """Let go, bring the hand to where a movement fits into its room, level it, and press again."""
        self.notes.clutches += 1
        self._assist.let_go(start_s)
        offset, turned = self.hand.aim()
        self.intent = replace(self.intent, hold=False)
        end_s = self.hand.move(start_s + self.hand.motor.reaction_s, begin_of(shift) - offset, turned.T)
        self._timing.press_s = end_s + SETTLE_S

    def _act(self, start_s: float) -> None:
        act = self._course.stage.act
        if act is Act.NOTHING:
            self._go_on(start_s)
        else:
            self._timing.gripped_s = self.hand.open_at(start_s) + GRIP_S

    def _watch_gripper(self, shown: ShownPage, now_s: float) -> None:
        """Go on when the gripper has done what the hand's opening asked for; ask again when it has not."""
        timing = self._timing
        if timing.gripped_s is None or now_s < self.hand.openings_s[-1] + OPENED_S:
            return
        closing = self._course.stage.act is Act.CLOSE
        if shown.gripper is (GripperStatus.HOLDING if closing else GripperStatus.OPEN):
            timing.gripped_s = None
            self._go_on(now_s)
        elif closing and shown.gripper is GripperStatus.CLOSED:
            self._grasp_again(now_s)
        elif now_s > timing.gripped_s:
            self._toggle(now_s)

    def _grasp_again(self, now_s: float) -> None:
        self.notes.misses += 1
        self._course.restart()
        self._settle(now_s)
        self._toggle(now_s)

    def _toggle(self, now_s: float) -> None:
        self._timing.gripped_s = self.hand.open_at(now_s + self.hand.motor.reaction_s) + GRIP_S

    def _go_on(self, now_s: float) -> None:
        self.notes.steps.append((now_s, self._course.stage.name))
        if not self._course.advance():
            self._judge()
        self._settle(now_s)

    def _settle(self, now_s: float) -> None:
        """Wait until the arm rests, and take the scales of the step under way."""
        self._timing.look_s = now_s + self._timing.settle_s
        scale, rotation = self._course.stage.scales
        if self._settings.scale != scale:
            revision = self._settings.revision + 1
            self._settings = replace(self._settings, revision=revision, scale=scale, rotation_scale=rotation)
            self.intent = replace(self.intent, settings=self._settings)

    def _judge(self) -> None:
        """Be content, or take the block once more."""
        self.notes.tries += 1
        scene = self._scene
        goal = PLACE[-1].goal(self._task, scene) if scene is not None else None
        if scene is None or scene.block is None or goal is None:
            self._finish(gave_up=True)
            return
        apart_m, apart_rad = _apart(goal, scene.block)
        straight = not self._steering.sees_turn or abs(apart_rad[2]) < GOOD_RAD
        good = bool(np.linalg.norm(apart_m[:2]) < GOOD_M and straight)
        if good or self.notes.tries >= MOST_TRIES:
            self._finish(gave_up=not good)
        else:
            self._course.restart()

    def _finish(self, gave_up: bool) -> None:
        self.notes.gave_up, self.done = gave_up, True
        self.intent = replace(self.intent, hold=False)


def _fallen(scene: Scene) -> bool:
    """Return whether the block lies on the table, where the gripper cannot take it."""
    return scene.block is not None and float(np.arccos(np.clip(scene.block[2, 2], -1.0, 1.0))) > FALLEN


def _apart(goal: Array, pose: Array) -> tuple[Array, Array]:
    """From a pose to a goal: (3,) m and a rotation vector (3,), in the base's axes."""
    return goal[:3, 3] - pose[:3, 3], vector_from_rotation(goal[:3, :3] @ pose[:3, :3].T)
