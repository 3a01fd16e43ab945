"""The experiment "icr": tracked elbow and wrist against centres of rotation, as in the thesis's tables 6.1 and 6.2."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from farhand.reports.plotting import describe_panel, panels, png
from lab.experiments.report import CsvTable, ExperimentReport, Figures, Progress
from lab.experiments.thesis.filmed import film_recorded
from lab.experiments.thesis.paths import Recorded, elbow_arc, wrist_arc
from lab.experiments.thesis.tables import MM, error_table, printed_table, with_total
from local_site.simulation.config import SimulationConfig

WINDOW, SETS, FRAMES, QUICK_FRAMES = 10, 65, 75, 20
SIMULATION = SimulationConfig()
PRINTED, TEN_CIRCLE, ARC, AXIS, TRUE = (
    "sphere, ten frames (as printed)",
    "circle, ten frames",
    "circle, whole arc",
    "axis, whole arc",
    "true joint",
)
THESIS: Mapping[str, Figures] = {
    "elbow": printed_table(
        [(10.8, 7.8, 8.5, 16.9), (5.3, 4.7, 5.8, 6.8), (20.5, 19.0, 24.9, 33.2), (0.1, 0.2, 0.1, 5.4)]
    ),
    "wrist": printed_table(
        [(13.6, 7.6, 12.0, 21.7), (7.5, 6.7, 5.5, 9.7), (27.2, 32.1, 30.6, 41.5), (0.1, 0.1, 0.1, 2.0)]
    ),
}
TABLES = {"elbow": "table 6.1, elbow", "wrist": "table 6.2, wrist"}
RATIO = "mean total, of the thesis's"
LINES = {
    method: {"color": color, "linewidth": 1.2}
    for method, color in zip(
        (PRINTED, TEN_CIRCLE, ARC, AXIS, TRUE), ("#d72828", "#2878c8", "#288c28", "#c88c14", "#282828"), strict=True
    )
}
AXES = ("X", "Y", "Z", "total")
TEXT = (
    "The forearm swings through 90 deg about the elbow, then the hand by 45 deg to either side about the wrist, while "
    "the rest of the arm stands still: 75 frames each (a quick run: 20). The marker on the end of the index finger, "
    "tracked by the marker tracker, gives the centre of rotation. The silhouette tracker's elbow or wrist, averaged "
    "over ten frames, is compared with it, in 65 sets of ten frames in a row. As printed, the centre is that of the "
    "sphere that fits the ten positions best (equations 5.2 and 5.3, with the outer square that the print lacks). But "
    "ten frames span only 11 deg of one plane, which do not determine a sphere: this reference is further off than "
    "the tracker. A circle does without the direction off the plane; one through the whole arc is exact to half a "
    "millimetre. Its centre lies on the axis of rotation at the height of the marker, which is not in the plane of "
    "the joint: the distance from the axis leaves this offset out. The last column is the error against the true "
    "joint, which only a simulation knows. In the thesis elbow and wrist moved, by about 1 and 2 mm per frame along "
    "each axis; here they stand still."
)


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle in space: its centre (3,), its axis (3,) of unit length, and its radius in the points' unit."""

    centre: Array
    axis: Array
    radius: float


def windows(rows: Array, size: int) -> Array:
    """Every run of consecutive rows, (N - size + 1, size, columns)."""
    return np.stack([rows[k : k + size] for k in range(len(rows) - size + 1)])


def fit_sphere(points: Array) -> tuple[Array, float]:
    """Centre (3,) and radius of the sphere with the least sum of (|point - centre|² - radius²)², of points (N, 3).

    Equation 5.3 with the square that its print lacks. Of points on one plane the noise decides how far the centre lies
    off the plane; of exact ones it lies on it.
    """
    middle = points.mean(axis=0)
    centre, radius = _fit_round(points - middle)
    return middle + centre, radius


def fit_circle(points: Array) -> Circle:
    """The circle of equation 5.3 within the plane that fits points (N, 3) best."""
    middle = points.mean(axis=0)
    axes = np.linalg.svd(points - middle, full_matrices=False)[2]
    centre, radius = _fit_round((points - middle) @ axes[:2].T)
    return Circle(middle + centre @ axes[:2], axes[2], radius)


def across_axis(vectors: Array, axis: Array) -> Array:
    """Vectors (N, 3) less their part along an axis (3,) of unit length."""
    across: Array = vectors - (vectors @ axis)[:, None] * axis
    return across


def _fit_round(points: Array) -> tuple[Array, float]:
    """Centre (d,) and radius by |p|² = 2 c·p + (radius² - |c|²), linear in c and the constant; points (N, d)."""
    squares = np.sum(points * points, axis=1)
    solution = np.linalg.lstsq(np.column_stack([2.0 * points, np.ones(len(points))]), squares, rcond=1e-9)[0]
    centre = solution[:-1]
    return centre, float(np.sqrt(max(solution[-1] + centre @ centre, 0.0)))


@dataclass(frozen=True, slots=True)
class TrackedArc:
    """One arc: the tracked and the true joint, and the tracked marker, each (N, 3) in m, NaN where not tracked."""

    joint: Array
    true_joint: Array
    marker: Array


def frame_count(quick: bool) -> int:
    """Count the frames that are filmed, for a progress bar."""
    return 2 * sum(recorded.filmed_frames for recorded in _recorded(quick).values())


def icr_report(quick: bool, progress: Progress) -> ExperimentReport:
    """Run the experiment; always the same for the same installation."""
    arcs = {joint: _swing(joint, recorded, progress) for joint, recorded in _recorded(quick).items()}
    errors = {joint: icr_errors_mm(arc) for joint, arc in arcs.items()}
    compared: dict[str, Figures] = {
        "thesis": {TABLES[joint]: {**table, RATIO: 1.0, "sets": SETS} for joint, table in THESIS.items()}
    }
    for method in (PRINTED, TEN_CIRCLE, ARC, AXIS, TRUE):
        compared[method] = {TABLES[joint]: _table(joint, of_joint[method]) for joint, of_joint in errors.items()}
    return ExperimentReport(
        title="Elbow and wrist against centres of rotation",
        text=TEXT,
        summary="\n".join(f"{method}: {_in_words(figures)}" for method, figures in compared.items()),
        figures={"experiment": "icr", "quick": quick, "seed": SIMULATION.seed, "runs": compared},
        compared=compared,
        plots={
            "figure_6_1_elbow": _plot("Absolute errors of the elbow (figure 6.1)", errors["elbow"]),
            "figure_6_2_wrist": _plot("Absolute errors of the wrist (figure 6.2)", errors["wrist"]),
        },
        data={f"icr_{joint}": _csv(of_joint) for joint, of_joint in errors.items()},
    )


def icr_errors_mm(arc: TrackedArc) -> Mapping[str, Array]:
    """By reference: the joint, averaged over each set of frames, less it (sets, 3), mm; NaN where a frame lacks."""
    joint, marker = (windows(rows, WINDOW)[:SETS] for rows in (arc.joint, arc.marker))
    mean_joint, whole = joint.mean(axis=1), fit_circle(arc.marker[np.isfinite(arc.marker).all(axis=1)])
    references = {
        PRINTED: _centres(marker, lambda points: fit_sphere(points)[0]),
        TEN_CIRCLE: _centres(marker, lambda points: fit_circle(points).centre),
        ARC: whole.centre,
        TRUE: windows(arc.true_joint, WINDOW)[:SETS].mean(axis=1),
    }
    errors = {method: MM * (mean_joint - reference) for method, reference in references.items()}
    return errors | {AXIS: across_axis(errors[ARC], whole.axis)}


def _centres(marker: Array, fit: Callable[[Array], Array]) -> Array:
    """The centre (sets, 3) of each set of positions (sets, WINDOW, 3), NaN where one is missing."""
    return np.array([fit(points) if np.isfinite(points).all() else np.full(3, np.nan) for points in marker])


def _recorded(quick: bool) -> Mapping[str, Recorded]:
    frames = QUICK_FRAMES if quick else FRAMES
    return {"elbow": elbow_arc(SIMULATION.body, frames), "wrist": wrist_arc(frames)}


def _swing(joint: str, recorded: Recorded, progress: Progress) -> TrackedArc:
    """Film and track the same motion twice: with a bare arm and with markers."""
    bare, marked = (film_recorded(SIMULATION, recorded, method, progress) for method in ("silhouette", "markers"))
    return TrackedArc(bare.tracked(joint), bare.true(joint), marked.tracked("index"))


def _table(joint: str, errors_mm: Array) -> Figures:
    """A table with the ratio of its first figure to the thesis's."""
    table = error_table(errors_mm)
    of_thesis = table["mean"]["total_mm"] / THESIS[joint]["mean"]["total_mm"]
    return {**table, RATIO: round(of_thesis, 2), "sets": int(np.isfinite(errors_mm).all(axis=1).sum())}


def _in_words(figures: Figures) -> str:
    means = (f"{name.split()[-1]} {table['mean']['total_mm']} mm" for name, table in figures.items())
    return ", ".join(means)


def _csv(errors_mm: Mapping[str, Array]) -> CsvTable:
    names = tuple(method.replace(",", "").replace(" ", "_").replace("(", "").replace(")", "") for method in errors_mm)
    columns = tuple(f"{name}_{axis}_error_mm" for name in names for axis in "xyz")
    sets = np.arange(1, len(errors_mm[TRUE]) + 1)
    return CsvTable(("set", *columns), np.column_stack([sets, *errors_mm.values()]))


def _plot(title: str, errors_mm: Mapping[str, Array]) -> bytes:
    """Absolute errors over the sets of frames, the references of ten frames beside that of the whole arc."""
    figure, axes = panels(title, len(AXES), 2, sharex=True)
    sets = np.arange(1, len(errors_mm[TRUE]) + 1)
    for k, (row, name) in enumerate(zip(axes, AXES, strict=True)):
        for panel, methods in zip(row, ((PRINTED, TEN_CIRCLE), (ARC, AXIS, TRUE)), strict=True):
            for method in methods:
                panel.plot(sets, with_total(errors_mm[method])[:, k], label=method, **LINES[method])
            describe_panel(panel, name, "absolute error, mm")
            panel.set_ylim(bottom=0.0)
    return png(figure, axes, "set of ten frames")
