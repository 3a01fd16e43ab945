"""Every figure that a table of the sources prints, and where ours of the same kind is in an experiment's report."""

from collections.abc import Iterator
from dataclasses import dataclass

from lab.experiments.placing import series as placing
from lab.experiments.robonaut.errors import REPORT_C, REPORT_S
from lab.experiments.thesis import calibration, icr
from lab.experiments.thesis.marker_figures import EXPECTED_MM, FIRST_TABLE, OFF, POINTS, off_expected_mm
from lab.experiments.thesis.marker_figures import THESIS as MARKERS

AXES = {"x_mm": "X", "y_mm": "Y", "z_mm": "Z", "total_mm": "total"}
ROLLS = {placing.ROLL_FIXED: ("table 6.12", "roll fixed"), placing.FREE: ("table 6.13", "all rotations")}
PLACED = {"x_mm": ("x", "mm"), "y_mm": ("y", "mm"), "angle_deg": ("angle", "deg")}


@dataclass(frozen=True, slots=True)
class Printed:
    """A figure in a source: where it stands, what it is, its unit and value.

    `path` leads to ours in the report.json of `experiment`.
    """

    where: str
    what: str
    unit: str
    theirs: float
    experiment: str
    path: tuple[str, ...]


def of_thesis() -> Iterator[Printed]:
    """The tables of the thesis, in its order."""
    yield from _calibration()
    yield from _centres_of_rotation()
    yield from _against_markers()
    yield from _placing()


def of_report() -> Iterator[Printed]:
    """The figures of the report of 2002."""
    for joint in ("shoulder_mm", "elbow_mm", "wrist_mm"):
        for figure, unit in (("mean", "mm"), ("variance", "mm²")):
            what = f"HAZEL-S, {joint.removesuffix('_mm')}: {figure} of the error"
            yield Printed(
                "section 4", what, unit, REPORT_S[joint][figure], "hazel", ("runs", "accurate", joint, figure)
            )
    for name, unit in (("finger_tip_mm", "mm"), ("in_the_picture_px", "px")):
        for figure in ("mean", "largest"):
            what = f"HAZEL-C, finger tip: {figure} error"
            path = ("runs", "rectangle, live", name, figure)
            yield Printed("section 4", what, unit, REPORT_C[name][figure], "hazel", path)


def _calibration() -> Iterator[Printed]:
    for axis, name in AXES.items():
        path = ("runs", calibration.DLT_25, "no distortion", axis)
        what = f"calibration by 25 discs: mean error, {name}"
        yield Printed("section 3.2.9", what, "mm", calibration.THESIS_MM[axis], "calibration", path)


def _centres_of_rotation() -> Iterator[Printed]:
    for joint, table in icr.TABLES.items():
        for method in (icr.PRINTED, icr.AXIS):
            for row in ("mean", "max"):
                what = f"{joint} off the centre of rotation ({method}): {row} total"
                path = ("runs", method, table, row, "total_mm")
                yield Printed(table.split(",")[0], what, "mm", icr.THESIS[joint][row]["total_mm"], "icr", path)


def _against_markers() -> Iterator[Printed]:
    for plane, tables in MARKERS.items():
        for k, point in enumerate(POINTS):
            where = f"table 6.{FIRST_TABLE[plane] + k}"
            what = (
                f"{point}, motion in {plane}: mean difference from its marker, off the {EXPECTED_MM[point]} mm expected"
            )
            path = ("runs", "Farhand", f"{where}, {plane}, {point}", OFF)
            yield Printed(where, what, "mm", round(off_expected_mm(tables[point], point), 1), "markers", path)


def _placing() -> Iterator[Printed]:
    for rolls, by_method in placing.THESIS.items():
        for method, figures in by_method.items():
            where, what = ROLLS[rolls] if method == "silhouette" else ("section 7.3", "the older system with markers")
            for name, theirs in figures.items():
                axis, unit = PLACED[name]
                path = (rolls, method, name, "median")
                yield Printed(where, f"a block placed, {what}: {axis}", unit, theirs, "placing", path)
