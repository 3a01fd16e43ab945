"""A task for a person to look at: its way points as a table, its path as a picture."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from common.geometry import Array
from farhand.teach.labels import LabelBox, in_words, placed, taken_together
from farhand.teach.planning import planned_path, way_points_in_base
from farhand.teach.task_file import Grip, TaskFile
from local_site.programmed.tool_trajectory import ToolTrajectory

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POSITION, ROTATION = ("x mm", "y mm", "z mm"), ("x deg", "y deg", "z deg")
VIEWS = (("from above", 0, 1), ("from the side", 0, 2), ("from the front", 1, 2))
GRIP_COLOURS: dict[Grip | None, str] = {"closed": "#d72828", "open": "#1e7d32", None: "#282828"}
PATH_COLOUR, LEADER_COLOUR = "#4a6fa5", "#9a9a9a"
DPI, FONT_PT = 130, 8
TOGETHER_PX, LEADER_PX = 12.0, 18.0
GRIP_SIZE, SIZE = 60, 14  # of a mark, in pt²
GRIP_RADIUS_PX, RIM_POINTS = 0.5 * GRIP_SIZE**0.5 * DPI / 72, 12
PATH_POINTS = 400  # of the path, to which labels give way


def as_table(task: TaskFile) -> Table:
    """A row for each way point, with when the tool is there at full speed; below, the whole way and its time."""
    path = planned_path(task)
    table = Table(
        "#",
        "at s",
        *POSITION,
        *ROTATION,
        "gripper",
        "dwell s",
        box=SIMPLE,
        caption=in_short(task, path),
        collapse_padding=True,
    )
    for number, (point, at_s) in enumerate(zip(task.waypoints, path.marks, strict=True), 1):
        numbers = [f"{value:.1f}" for value in (at_s, *point.xyz_mm, *point.rotation_deg)]
        dwell = f"{point.dwell_s:g}" if point.dwell_s else ""
        table.add_row(str(number), *numbers, point.gripper or "", dwell)
    return table


def as_builtins(task: TaskFile) -> dict[str, Any]:
    """The same for programs."""
    path = planned_path(task)
    points = zip(task.waypoints, path.marks, strict=True)
    return {
        "name": task.task.name,
        "duration_s": path.duration_s,
        "way_points": [{"at_s": at_s, **msgspec.structs.asdict(point)} for point, at_s in points],
    }


def in_short(task: TaskFile, path: ToolTrajectory) -> str:
    """Say how many way points there are, how long the whole way is, and its time."""
    way_mm = 1e3 * float(np.linalg.norm(np.diff(path.positions, axis=0), axis=1).sum())
    return f"{len(task.waypoints)} way points, {way_mm:.0f} mm in {path.duration_s:.1f} s without the gripper's time"


def plotted(task: TaskFile) -> "Figure":
    """The tool's way in the base frame, from three sides; way points by number, the gripper's actions in colour."""
    from matplotlib.figure import Figure  # noqa: PLC0415  # an extra

    path = planned_path(task)
    way_mm = 1e3 * path.positions
    points_mm = np.array([1e3 * pose[:3, 3] for pose in way_points_in_base(task)])
    figure = Figure(figsize=(15.0, 5.6), dpi=DPI, layout="constrained")
    figure.suptitle(task.task.name, parse_math=False)
    views = list(zip(figure.subplots(1, 3), VIEWS, strict=True))
    for axes, (name, across, up) in views:
        axes.plot(way_mm[:, across], way_mm[:, up], color=PATH_COLOUR, linewidth=1.4, zorder=2)
        for at_mm, point in zip(points_mm, task.waypoints, strict=True):
            size = GRIP_SIZE if point.gripper else SIZE
            axes.scatter(at_mm[across], at_mm[up], s=size, color=GRIP_COLOURS[point.gripper], zorder=3)
        axes.set_title(name)
        axes.set_xlabel(f"{'xyz'[across]} (mm)")
        axes.set_ylabel(f"{'xyz'[up]} (mm)")
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.12)
    figure.draw_without_rendering()  # from here on every point has its pixel
    for axes, (_, across, up) in views:
        _label(axes, task, points_mm[:, [across, up]], way_mm[:, [across, up]])
    return figure


def _label(axes: Any, task: TaskFile, points_mm: Array, way_mm: Array) -> None:
    """Name the way points of a view by their numbers, those that lie together at once."""
    points, way = axes.transData.transform(points_mm), axes.transData.transform(way_mm)
    groups = taken_together(points, TOGETHER_PX)
    texts = [_text(axes, task, group) for group in groups]
    boxes = [text.get_window_extent() for text in texts]
    anchors, sizes = points[[group[0] for group in groups]], np.array([(box.width, box.height) for box in boxes])
    obstacles = [points, *_rims(task, points), way[:: max(len(way) // PATH_POINTS, 1)]]
    found = placed(anchors, sizes, np.concatenate(obstacles), LabelBox(*axes.bbox.extents))
    to_mm = axes.transData.inverted()
    for text, anchor, place in zip(texts, anchors, found, strict=True):
        text.set_position(to_mm.transform(place[:2]))
        nearest = np.clip(anchor, place[:2], place[2:])
        if np.linalg.norm(nearest - anchor) > LEADER_PX:
            ends = to_mm.transform([anchor, nearest])
            axes.plot(*ends.T, color=LEADER_COLOUR, linewidth=0.7, zorder=1, scalex=False, scaley=False)


def _rims(task: TaskFile, points: Array) -> Iterator[Array]:
    """Points around each mark of the gripper, which is larger than a point."""
    angles = np.linspace(0.0, 2 * np.pi, RIM_POINTS, endpoint=False)
    rim = GRIP_RADIUS_PX * np.column_stack([np.cos(angles), np.sin(angles)])
    return (at + rim for at, point in zip(points, task.waypoints, strict=True) if point.gripper is not None)


def _text(axes: Any, task: TaskFile, group: list[int]) -> Any:
    """The label of some way points, not placed yet."""
    acts = {k + 1: grip for k in group if (grip := task.waypoints[k].gripper) is not None}
    if len(group) == 1:
        words = " ".join([f"{group[0] + 1}", *acts.values()])
    else:
        words = "\n".join([in_words([k + 1 for k in group]), *(f"{number} {grip}" for number, grip in acts.items())])
    colour = GRIP_COLOURS[next(iter(acts.values()), None)]
    return axes.text(0.0, 0.0, words, fontsize=FONT_PT, color=colour, zorder=4, in_layout=False)
