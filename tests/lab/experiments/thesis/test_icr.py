"""The centres of rotation as the command reports them: the errors that the documents promise, and what is counted."""

import numpy as np
import pytest

from lab.experiments.thesis import icr
from lab.experiments.thesis.paths import elbow_arc
from local_site.simulation.config import BodyConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator

# Mean distance from the axis of the whole arc in mm, as documented; a quick run sweeps the same arc in fewer frames.
DOCUMENTED_MM = {"elbow": 8.4, "wrist": 3.9}
TOLERANCE_MM = 1.0


@pytest.fixture(scope="module")
def report():
    frames = []
    made = icr.icr_report(True, lambda: frames.append(1))
    assert len(frames) == icr.frame_count(True)
    return made


def means(report, joint):
    return {method: tables[icr.TABLES[joint]]["mean"]["total_mm"] for method, tables in report.compared.items()}


@pytest.mark.parametrize("joint", DOCUMENTED_MM)
def test_the_joints_are_as_near_to_their_axes_as_documented_and_nearer_than_the_thesis(joint, report):
    found = means(report, joint)
    assert found[icr.AXIS] == pytest.approx(DOCUMENTED_MM[joint], abs=TOLERANCE_MM)
    assert found[icr.TRUE] == pytest.approx(found[icr.AXIS], abs=TOLERANCE_MM)
    assert found["thesis"] == {"elbow": 16.9, "wrist": 21.7}[joint]
    ours = report.compared[icr.AXIS][icr.TABLES[joint]]
    assert ours[icr.RATIO] == pytest.approx(ours["mean"]["total_mm"] / found["thesis"], abs=0.006)


def test_plots_and_data_are_those_of_the_thesis(report):
    assert set(report.plots) == {"figure_6_1_elbow", "figure_6_2_wrist"}
    assert {name: data.rows.shape for name, data in report.data.items()} == {
        "icr_elbow": (icr.QUICK_FRAMES - 9, 16),
        "icr_wrist": (icr.QUICK_FRAMES - 9, 16),
    }


def test_the_elbow_stands_still_while_the_forearm_sweeps_a_right_angle():
    recorded = elbow_arc(BodyConfig(), 75)
    operator = SimulatedOperator(SimulationConfig(motion=recorded.motion), recorded.path)
    poses = [operator.pose(recorded.seconds - k / 5.0) for k in reversed(range(75))]
    assert np.ptp([pose.elbow for pose in poses], axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    first, last = (poses[k].wrist - poses[k].elbow for k in (0, -1))
    assert first @ last == pytest.approx(0.0, abs=1e-9)
    for pose in poses:  # the hand keeps its place at the end of the forearm
        along = pose.operator_R_hand.T @ (pose.wrist - pose.elbow)
        assert along == pytest.approx([0.28, 0.0, 0.0], abs=0.006)


def test_a_frame_without_the_joint_leaves_out_every_set_it_is_in():
    angles = np.radians(np.linspace(0.0, 90.0, 75))
    marker = np.column_stack([np.cos(angles), np.sin(angles), np.full(75, 0.02)])
    joint = np.zeros((75, 3))
    joint[30] = np.nan
    marker[31] = np.nan
    errors = icr.icr_errors_mm(icr.TrackedArc(joint, np.zeros((75, 3)), marker))
    assert {name: int(np.isfinite(rows).all(axis=1).sum()) for name, rows in errors.items()} == {
        icr.PRINTED: 54,
        icr.TEN_CIRCLE: 54,
        icr.ARC: 55,
        icr.AXIS: 55,
        icr.TRUE: 55,
    }
    assert np.nanmax(np.abs(errors[icr.AXIS])) < 1e-6
    assert np.nanmean(np.abs(errors[icr.ARC][:, 2])) == pytest.approx(20.0)
