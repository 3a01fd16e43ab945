"""Finds block, target and gripper in the views that stand still, as poses in the base's frame."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from common.messages.robot import GripperStatus
from lab.visual_operator.shown import ShownPage, ShownView
from lab.visual_operator.sight.coloured import (
    ColouredThing,
    coloured_block,
    coloured_fingers,
    coloured_paper,
    finger_spots,
    papers_in,
)
from lab.visual_operator.sight.edge_fit import SeenShape, fit_edges, project
from lab.visual_operator.sight.outlines import outline
from lab.visual_operator.sight.pose_fit import SeenOutline, fit_pose
from lab.visual_operator.task import PlacingTask

LEAST_VIEWS = 2
TARGET_LOOKS = 25  # pages after which the target is taken as known
GOOD_PX = 2.5  # the largest residual of a fit that is believed
RIDING_REACH = 5.0  # how much further the block is looked for in a view from the tool
# Standard deviations of an expected pose, position (m) and rotation (rad): of what was seen before, of a thing that
# lies or stands, of a level gripper, and of a gripper whose fingers were fitted.
NEAR = np.array([0.03] * 3 + [0.15] * 3)
LYING_NEAR = np.array([0.03, 0.03, 0.001, 0.002, 0.002, 0.15])
STANDING = np.array([0.3, 0.3, 0.002, 0.004, 0.004, 0.6])
LEVEL = np.array([0.3, 0.3, 0.3, 0.02, 0.02, 0.1])
BY_FINGERS = np.array([0.001] * 3 + [0.05, 0.05, 0.15])
HALF_TURN = np.diag([1.0, -1.0, -1.0])  # about the gripper's x: one finger where the other was
LEVEL_NEAR = np.array([0.03] * 3 + [0.03, 0.03, 0.15])


@dataclass(frozen=True, slots=True)
class Scene:
    """Poses (4 x 4) in the base's frame; None for what was not found in two views.

    `t_ns` is when the oldest of the pictures was taken.
    """

    t_ns: int
    block: Array | None
    gripper: Array | None
    target: Array | None


class Sight:
    """Looks at one page after the other; the target's pose is the median over the first pages that show it."""

    def __init__(self, task: PlacingTask) -> None:
        self._task = task
        self._block: Array | None = None
        self._gripper: Array | None = None
        self._target: Array | None = None
        self._targets: list[Array] = []

    def see(self, shown: ShownPage) -> Scene:
        """Find what is in the views that stand still, and the gripper also in those that ride on the tool."""
        fixed = [view for view in shown.views.values() if not view.on_tool]
        riding = [view for view in shown.views.values() if view.on_tool]
        if len(self._targets) < TARGET_LOOKS:
            self._look_at_target(fixed)
        self._block = self._find_block(fixed)
        if shown.gripper is GripperStatus.HOLDING and self._block is not None:
            self._gripper = self._task.grasp_of(self._block)
        else:
            self._gripper = self._find_gripper(fixed, riding, shown.opening_m)
        oldest_ns = min((view.capture_ns for view in fixed), default=0)
        return Scene(oldest_ns, self._block, self._gripper, self._target)

    def _look_at_target(self, fixed: Sequence[ShownView]) -> None:
        """Find the target once more, and take the median: the first pictures over a network are coarse."""
        found = self._find_target(fixed)
        if found is not None:
            self._targets.append(found)
            self._target = _middle_pose(self._targets)

    def _find_block(self, views: Sequence[ShownView]) -> Array | None:
        task = self._task
        marks = task.marks_on(self._target) if self._target is not None else None
        seen = [found for view in views if (found := coloured_block(view, marks)) is not None]
        shapes = [SeenShape(task.block_shape(), found.block) for found in seen]
        shapes += [SeenShape(task.stripe_shape(), found.stripe) for found in seen]
        pose = _near(shapes, self._block, NEAR)
        if pose is not None:
            return pose
        upright = task.table_z + task.block_size[2] / 2
        rough = _rough(task.block_shape(), [found.block for found in seen], np.eye(3), STANDING, upright)
        return _near(shapes, rough, NEAR)

    def _find_gripper(self, fixed: Sequence[ShownView], riding: Sequence[ShownView], opening_m: float) -> Array | None:
        """Find it near where it was, else by the outlines of its fingers, level and turned as before."""
        pointed = self._gripper if self._gripper is not None else transform(self._task.base_R_gripper, np.zeros(3))
        found = None
        if self._gripper is not None:
            found = self._gripper_near(self._gripper, fixed, riding, opening_m)
        if found is None:
            seen = [thing for view in fixed if (thing := coloured_fingers(view)) is not None]
            fingers, level = self._task.fingers_shape(opening_m), self._task.levelled(pointed[:3, :3])
            rough = _rough(fingers, seen, level, LEVEL)
            found = self._gripper_near(rough, fixed, riding, opening_m) if rough is not None else None
        return None if found is None else self._pointing_ahead(found)

    def _pointing_ahead(self, pose: Array) -> Array:
        """Choose of two poses that look the same, half a turn apart, the one that does not point back at the robot."""
        if pose[:3, 2] @ self._task.base_R_gripper[:, 2] > 0:
            return pose
        return transform(pose[:3, :3] @ HALF_TURN, pose[:3, 3])

    def _gripper_near(
        self, pose: Array, fixed: Sequence[ShownView], riding: Sequence[ShownView], opening_m: float
    ) -> Array | None:
        """Find it by its fingers; where riding cameras show the block, that determines the rotation best."""
        task, block = self._task, self._block
        shapes = [shape for view in fixed for shape in self._fingers_in(view, opening_m, pose)]
        by_fingers = _near(shapes, pose, LEVEL_NEAR)
        if by_fingers is None or block is None:
            return by_fingers
        by_block = [
            SeenShape(task.block_shape(), found.block, self._in_tool(block), RIDING_REACH, inner=True)
            for view in riding
            if (found := coloured_block(view, None, task.gripper_in_tool(opening_m))) is not None
        ]
        return _near([*shapes, *by_block], by_fingers, BY_FINGERS) if by_block else by_fingers

    def _fingers_in(self, view: ShownView, opening_m: float, pose: Array) -> list[SeenShape]:
        """Each finger on its own where the view shows both apart; else what looks most like the spot: one, or both."""
        task, spots = self._task, finger_spots(view)
        fingers = [task.finger_shape(opening_m, side) for side in (1.0, -1.0)]
        shown = [project(view.projection, f @ pose[:3, :3].T + pose[:3, 3]) for f in fingers]
        if len(spots) == 2:
            middles = [spot.box.mean(axis=0) for spot in spots]
            straight = (shown[1] - shown[0]).mean(axis=0) @ (middles[1] - middles[0]) > 0
            return [SeenShape(f, s) for f, s in zip(fingers, spots if straight else spots[::-1], strict=True)]
        if not spots:
            return []
        shapes = [(f, px) for f, px in zip(fingers, shown, strict=True)]
        shapes.append((np.concatenate(fingers), np.concatenate(shown)))
        misses = [np.abs(np.array([px.min(axis=0), px.max(axis=0)]) - spots[0].box).sum() for _, px in shapes]
        return [SeenShape(shapes[int(np.argmin(misses))][0], spots[0])]

    def _in_tool(self, thing: Array) -> Callable[[Array], Array]:
        """The pose in the tool's frame of a thing (4 x 4) in the base's, given that of the fingers."""
        return lambda fingers: self._task.tcp_T_fingers @ np.linalg.inv(fingers) @ thing

    def _find_target(self, views: Sequence[ShownView]) -> Array | None:
        """Find the white square with red at its corner in one view, and fit it in all that show it."""
        task = self._task
        for place in (place for view in views for place in papers_in(view, task)):
            seen = [t for view in views if (t := coloured_paper(view, place + task.paper_shape())) is not None]
            if len(seen) >= LEAST_VIEWS:
                shapes = [SeenShape(task.paper_shape(), thing) for thing in seen]
                pose = _near(shapes, transform(np.eye(3), place), LYING_NEAR)
                if pose is not None:
                    return pose
        return None


def _middle_pose(poses: Sequence[Array]) -> Array:
    """The pose (4 x 4) whose position and rotation are the medians of these, which are near each other."""
    first = poses[0][:3, :3]
    turns = np.array([vector_from_rotation(pose[:3, :3] @ first.T) for pose in poses])
    middle = np.median([pose[:3, 3] for pose in poses], axis=0)
    return transform(rotation_from_vector(np.median(turns, axis=0)) @ first, middle)


def _near(shapes: Sequence[SeenShape], before: Array | None, sigmas: Array) -> Array | None:
    """The pose near where the thing was `before`; None where it is not there, or in fewer than two views."""
    if before is None or len(shapes) < LEAST_VIEWS:
        return None
    fitted = fit_edges(shapes, before, sigmas)
    return fitted.pose if fitted is not None and fitted.residual_px < GOOD_PX else None


def _rough(
    shape: Array, seen: Sequence[ColouredThing], rotation: Array, sigmas: Array, z: float | None = None
) -> Array | None:
    """The pose of a thing from its outlines, near a rotation (3 x 3), and a height where that is known."""
    outlines = [
        SeenOutline(found, thing.projection)
        for thing in seen
        if (found := outline(thing.above, thing.corner, thing.size)) is not None
    ]
    if len(outlines) < LEAST_VIEWS:
        return None
    middle = _middle(outlines)
    middle[2] = middle[2] if z is None else z
    return fit_pose(shape, outlines, transform(rotation, middle), sigmas).pose


def _middle(seen: Sequence[SeenOutline]) -> Array:
    """Compute where the middles of the outlines nearly meet (3,)."""
    rows = []
    for s in seen:
        x, y = s.outline.centre
        # x = P[0] X / P[2] X for the homogeneous point X, so (x P[2] - P[0]) X = 0; likewise for y.
        rows += [x * s.projection[2] - s.projection[0], y * s.projection[2] - s.projection[1]]
    matrix = np.array([row / np.linalg.norm(row[:3]) for row in rows])
    point, *_ = np.linalg.lstsq(matrix[:, :3], -matrix[:, 3], rcond=None)
    return np.asarray(point)
