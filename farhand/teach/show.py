"""A task for a person to look at: its way points as a table, its path as a picture."""

from typing import TYPE_CHECKING

from rich.box import SIMPLE
from rich.table import Table

from farhand.teach.planning import planned_path
from farhand.teach.task_file import TaskFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEWS = (("from above", 0, 1), ("from the side", 0, 2), ("from the front", 1, 2))
GRIP_COLOURS = {"closed": "#d72828", "open": "#1e7d32"}


def as_table(task: TaskFile) -> Table:
    """A row for each way point, with when the tool is there at full speed."""
    table = Table("#", "s", "x mm", "y", "z", "turn x deg", "y", "z", "gripper", "dwell s", box=SIMPLE)
    for number, (point, at_s) in enumerate(zip(task.waypoints, planned_path(task).marks, strict=True), 1):
        numbers = [f"{value:.1f}" for value in (at_s, *point.xyz_mm, *point.rotation_deg)]
        dwell = f"{point.dwell_s:g}" if point.dwell_s else ""
        table.add_row(str(number), *numbers, point.gripper or "", dwell)
    return table


def plotted(task: TaskFile) -> "Figure":
    """The tool's way in the base frame, from three sides; way points by number, the gripper's actions in colour."""
    from matplotlib.figure import Figure  # noqa: PLC0415  # an extra

    path = planned_path(task)
    way_mm = 1e3 * path.positions
    points_mm = [1e3 * (task.frame.base_T_frame @ point.frame_T_tool)[:3, 3] for point in task.waypoints]
    figure = Figure(figsize=(12.0, 4.4), layout="constrained")
    figure.suptitle(task.task.name)
    for axes, (name, across, up) in zip(figure.subplots(1, 3), VIEWS, strict=True):
        axes.plot(way_mm[:, across], way_mm[:, up], color="#4a6fa5", linewidth=1.4, zorder=2)
        for number, (at_mm, point) in enumerate(zip(points_mm, task.waypoints, strict=True), 1):
            colour = GRIP_COLOURS.get(point.gripper or "", "#282828")
            size = 60 if point.gripper else 14
            axes.scatter(at_mm[across], at_mm[up], s=size, color=colour, zorder=3)
            words = f"{number} {point.gripper}" if point.gripper else str(number)
            axes.annotate(words, (at_mm[across], at_mm[up]), (4, 4), textcoords="offset points", fontsize=7)
        axes.set_title(name)
        axes.set_xlabel(f"{'xyz'[across]} (mm)")
        axes.set_ylabel(f"{'xyz'[up]} (mm)")
        axes.set_aspect("equal", adjustable="datalim")
    return figure
