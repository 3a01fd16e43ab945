"""Every figure that the sources draw of their results, and the plot of ours that an experiment writes."""

from collections.abc import Iterator
from dataclasses import dataclass

from lab.experiments.thesis.marker_figures import FIRST_FIGURE, POINTS

TOTAL = "total difference"


@dataclass(frozen=True, slots=True)
class DrawnFigure:
    """A figure in a source, what it shows, and the file of ours in the folder of `experiment`."""

    where: str
    what: str
    experiment: str
    file: str


def in_thesis() -> Iterator[DrawnFigure]:
    """The figures of the thesis, in its order."""
    yield DrawnFigure("figure 3.25", "the plate at three heights", "calibration", "figure_3_25_plate.png")
    yield DrawnFigure("figure 6.1", "the elbow against its centre of rotation", "icr", "figure_6_1_elbow.png")
    yield DrawnFigure("figure 6.2", "the wrist against its centre of rotation", "icr", "figure_6_2_wrist.png")
    for plane, first in FIRST_FIGURE.items():
        for k, point in enumerate((*POINTS, "total")):
            shows = f"{TOTAL}s, motion in {plane}" if point == "total" else f"{point}, motion in {plane}"
            file = f"figure_6_{first + k}_{plane.lower()}_{point}.png"
            yield DrawnFigure(f"figure 6.{first + k}", shows, "markers", file)
    yield DrawnFigure("figure 6.15", "positions of hand and tool", "follow", "figure_6_15_positions.png")
    yield DrawnFigure("figure 6.16", "orientations of hand and tool", "follow", "figure_6_16_orientations.png")


def in_report() -> Iterator[DrawnFigure]:
    """The figures of the report of 2002 from 9 on, which show its results."""
    for number, shows, file in (
        (9, "frames of HAZEL-S", "figure_9_hazel_s_frames.png"),
        (10, "HAZEL-S: motion from frame to frame", "figure_10_motion.png"),
        (11, "HAZEL-S: positions", "figure_11_positions.png"),
        (12, "HAZEL-S: errors", "figure_12_errors.png"),
        (13, "frames of HAZEL-C, with the model over them", "figure_13_hazel_c_frames.png"),
        (14, "HAZEL-C: motion from frame to frame", "figure_14_hazel_c_motion.png"),
        (15, "the finger tip on its rectangle", "figure_15_finger_tip.png"),
        (16, "errors of the finger tip", "figure_16_finger_errors.png"),
    ):
        yield DrawnFigure(f"figure {number}", shows, "hazel", file)
    for number, shows, file in (
        (17, "frames of HAZEL-A, with the model over them", "figure_17_hazel_a_frames.png"),
        (18, "HAZEL-A: motion from frame to frame", "figure_18_hazel_a_motion.png"),
        (19, "frames of HAZEL-B, with the model over them", "figure_19_hazel_b_frames.png"),
        (20, "HAZEL-B: motion from frame to frame", "figure_20_hazel_b_motion.png"),
        (21, "the humanoid during HAZEL-A, from the front and from the side", "figure_21_hazel_a_humanoid.png"),
        (22, "the humanoid during HAZEL-B, from the front and from the side", "figure_22_hazel_b_humanoid.png"),
    ):
        yield DrawnFigure(f"figure {number}", shows, "robonaut", file)
