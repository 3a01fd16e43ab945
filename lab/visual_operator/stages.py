"""The steps of the task, as a person would do them: where to bring the gripper or the block, how exactly, what then."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from common.geometry import Array
from lab.visual_operator.sight.sight import Scene
from lab.visual_operator.task import PlacingTask

BACK_M, OVER_M, LIFT_M, ABOVE_M = 0.055, 0.10, 0.05, 0.012
BLOCK, PAPER = "block", "paper"  # the targets of fine adjustment, as the page names them
COARSE, CAREFUL, FINE = (1.0, 1.0), (0.5, 0.5), (0.25, 0.5)

Goal = Callable[[PlacingTask, Scene], Array | None]


class Moves(Enum):
    """The thing that a step brings to its goal."""

    GRIPPER = "gripper"
    BLOCK = "block"


class Act(Enum):
    """The action once a step's goal is reached."""

    NOTHING = "nothing"
    CLOSE = "close"
    OPEN = "open"


@dataclass(frozen=True, slots=True)
class Stage:
    """One step: `goal` of the scene (None while it cannot be seen); within how many m and rad it counts as reached.

    `looks` is in how many pictures in a row; `scales` are those of the hand's motion and rotation; `assist` names the
    target to which the robot leads the tool, if the cell has one.
    """

    name: str
    moves: Moves
    goal: Goal
    within_m: float
    within_rad: float
    scales: tuple[float, float] = COARSE
    looks: int = 1
    act: Act = Act.NOTHING
    assist: str | None = None


def _grasp(back: float, up: float) -> Goal:
    return lambda task, scene: None if scene.block is None else task.grasp_of(scene.block, back, up)


def _over_target(up: float) -> Goal:
    def goal(task: PlacingTask, scene: Scene) -> Array | None:
        if scene.target is None:
            return None
        pose = task.block_on(task.flat(scene.target))
        pose[2, 3] += up
        return pose

    return goal


def _lifted(task: PlacingTask, scene: Scene) -> Array | None:
    if scene.block is None:
        return None
    pose = task.upright(scene.block)
    pose[2, 3] = task.table_z + task.block_size[2] / 2 + LIFT_M
    return pose


GRASP = (
    Stage("above", Moves.GRIPPER, _grasp(BACK_M, OVER_M), 0.015, np.radians(6)),
    Stage("behind", Moves.GRIPPER, _grasp(BACK_M, 0.0), 0.010, np.radians(6)),
    Stage("reach", Moves.GRIPPER, _grasp(0.0, 0.0), 0.005, np.radians(3), CAREFUL, act=Act.CLOSE, assist=BLOCK),
)
PLACE = (
    Stage("lift", Moves.BLOCK, _lifted, 0.012, np.radians(8)),
    Stage("carry", Moves.BLOCK, _over_target(LIFT_M), 0.008, np.radians(4)),
    Stage("align", Moves.BLOCK, _over_target(ABOVE_M), 0.0025, np.radians(1.5), FINE, looks=2, assist=PAPER),
    Stage("lower", Moves.BLOCK, _over_target(0.0), 0.0025, np.radians(2), FINE, act=Act.OPEN, assist=PAPER),
)
RETREAT = (Stage("retreat", Moves.GRIPPER, _grasp(BACK_M, 0.0), 0.02, np.radians(15)),)


class Course:
    """The progress of the task: grasp, place, retreat, and again where grasp or place was bad."""

    def __init__(self) -> None:
        self._stages: Sequence[Stage] = GRASP
        self._at = self._looks = 0

    @property
    def stage(self) -> Stage:
        """The step under way."""
        return self._stages[self._at]

    @property
    def holding(self) -> bool:
        """Return whether the block is in the gripper."""
        return self._stages is PLACE

    def seen(self, reached: bool) -> bool:
        """Take one look at the step's goal; whether it has been reached in as many looks in a row as it asks for."""
        self._looks = self._looks + 1 if reached else 0
        return self._looks >= self.stage.looks

    def advance(self) -> bool:
        """Go on to the next step; False when that was the last one."""
        self._looks = 0
        if self._at + 1 < len(self._stages):
            self._at += 1
        elif self._stages is RETREAT:
            return False
        else:
            self._stages, self._at = PLACE if self._stages is GRASP else RETREAT, 0
        return True

    def restart(self) -> None:
        """Grasp the block again."""
        self._stages, self._at, self._looks = GRASP, 0, 0
