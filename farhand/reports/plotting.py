"""Draws curves as PNG with matplotlib (the extra `experiments`), without a display and without global state."""

import importlib.util
import io
from typing import TYPE_CHECKING, Any

from common.errors import FarhandError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL_WIDTH_IN, PANEL_HEIGHT_IN, HEAD_IN = 6.0, 2.1, 0.6
WIDTH_OF_ONE_IN = 7.5
LABELS_PER_PANEL = 3
DPI = 130
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib
    "font.size": 9,
    "figure.titlesize": 12,
    "figure.titleweight": "bold",
    "axes.edgecolor": "#6e6e6e",
    "axes.grid": True,
    "axes.xmargin": 0.01,
    "axes.axisbelow": True,
    "grid.color": "#e1e1e1",
    "xtick.color": "#6e6e6e",
    "ytick.color": "#6e6e6e",
}
TRUE: dict[str, Any] = {"label": "true", "color": "#282828", "linewidth": 2.6}
MEASURED: dict[str, Any] = {"label": "measured", "color": "#d72828", "linewidth": 0.9}


def require_matplotlib() -> None:
    """FarhandError states what to install where matplotlib is missing."""
    if importlib.util.find_spec("matplotlib") is None:
        raise FarhandError("plots need matplotlib, which is not installed: pip install 'farhand[experiments]'")


def panels(title: str, rows: int, columns: int = 1, **shared: Any) -> "tuple[Figure, Any]":
    """A figure with a title, and its axes (rows, columns); `shared` is which of them have an axis in common."""
    import matplotlib  # noqa: PLC0415  # an extra: `require_matplotlib` is asked before any work
    from matplotlib.figure import Figure  # noqa: PLC0415  # without pyplot, which would keep figures and look for a display

    width_in = WIDTH_OF_ONE_IN if columns == 1 else columns * PANEL_WIDTH_IN
    with matplotlib.rc_context(STYLE):
        figure = Figure((width_in, HEAD_IN + rows * PANEL_HEIGHT_IN), DPI, layout="constrained")
        figure.suptitle(title, x=0.01, horizontalalignment="left")
        return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def describe_panel(axes: "Axes", title: str, y_label: str) -> None:
    """Write over a panel what it shows, and along its y axis in which unit."""
    axes.set_title(title, fontsize="medium", loc="left")
    axes.set_ylabel(y_label)


def widen(axes: "Axes", min_span: float) -> None:
    """Widen the y axis to span at least `min_span`, in its own unit, so that noise does not look like motion."""
    low, high = axes.get_ylim()
    missing = max(min_span - (high - low), 0.0)
    axes.set_ylim(low - 0.5 * missing, high + 0.5 * missing)


def png(figure: "Figure", axes: Any, x_label: str) -> bytes:
    """The figure as PNG: its last row labelled, a legend of all curves below."""
    for panel in axes[-1]:
        panel.set_xlabel(x_label)
    curves = {
        label: line for panel in axes.flat for line, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    labels, handles = list(curves), list(curves.values())
    columns = min(len(labels), LABELS_PER_PANEL * axes.shape[1])
    figure.legend(
        handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=STYLE["font.size"]
    )
    content = io.BytesIO()
    figure.savefig(content, format="png")
    return content.getvalue()
