"""The plots of hand against tool: places (figure 6.15) and directions (figure 6.16), both ways side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from common.cameras.camera import Image
from farhand.experiments.charts import Line, Panel, common_range, figure
from farhand.experiments.follow import Curves, Figures, seconds

TRUE, MEASURED, TOOL = (40, 40, 40), (235, 180, 100), (40, 40, 215)
NAMES = ("X", "Y", "Z", "XY plane", "XZ plane")
LEAST_MM, LEAST_DEG = 10.0, 4.0


@dataclass(frozen=True, slots=True)
class Way:
    """One way to follow: its name, its frames per second, its curves and figures."""

    name: str
    fps: float
    curves: Curves
    figures: Figures


def follow_plots(ways: Sequence[Way]) -> Mapping[str, Image]:
    """All plots by the name of their file."""
    return {
        "positions": figure(
            "Position since the start, in the operator's axes; lag and residual of the tool behind the true hand",
            [[_panel(ways, way, column) for way in ways] for column in range(3)],
        ),
        "orientations": figure(
            "Direction since the start, in the operator's axes; lag and residual of the tool behind the true hand",
            [[_panel(ways, way, column) for way in ways] for column in range(3, 5)],
        ),
    }


def _panel(ways: Sequence[Way], way: Way, column: int) -> Panel:
    rows = [r[:, column] for w in ways for r in (w.curves.hand_true, w.curves.hand_measured, w.curves.tool)]
    is_angle = column >= 3
    time_s, curves = seconds(way.curves.frames_ns), way.curves
    lines = (
        Line("hand, measured", MEASURED, 4, time_s, curves.hand_measured[:, column]),
        Line("hand, true", TRUE, 1, time_s, curves.hand_true[:, column]),
        Line("tool", TOOL, 2, time_s, curves.tool[:, column]),
    )
    return Panel(
        title=f"{NAMES[column]}, {way.name}: {_told(way.figures, column)}",
        x_label=f"time, s ({way.fps:g} frames each)",
        y_label=f"{NAMES[column]}, {'deg' if is_angle else 'mm'}",
        lines=lines,
        x_range=(0.0, float(max(seconds(w.curves.frames_ns)[-1] for w in ways))),
        y_range=common_range(rows, LEAST_DEG if is_angle else LEAST_MM),
    )


def _told(figures: Figures, column: int) -> str:
    """Lag and residual of one column behind the true and, in brackets, behind the measured hand."""
    lag_ms, rest = _lag_and_rest(figures["tool_behind_true_hand"], column)
    measured_lag_ms, measured_rest = _lag_and_rest(figures["tool_behind_measured_hand"], column)
    unit = "mm" if column < 3 else "deg"
    return f"lag {lag_ms:.0f} ms, residual {rest:.1f} {unit} (measured: {measured_lag_ms:.0f}, {measured_rest:.1f})"


def _lag_and_rest(behind: Figures, column: int) -> tuple[float, float]:
    if column < 3:
        return behind["lag_ms"], behind["residual_by_axis_mm"]["xyz"[column]]
    return behind["angle_lag_ms"], behind["residual_deg"][("xy_deg", "xz_deg")[column - 3]]["mean"]
