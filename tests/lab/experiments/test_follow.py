"""The experiment as it is run from the command line: its folder, its figures, and how it fails."""

import json

import cv2
import numpy as np
import pytest

from common.errors import ConfigError, InterruptionError
from farhand.outputs import write_result
from lab.experiments.follow import HAND_MEASURED, TOOL
from lab.experiments.following import film
from lab.experiments.run import run_experiment
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.tracking.choice import TrackingConfig
from tests.present import present

VARIANTS = {"mean_5fps": 5, "kinematic_30fps": 30, "mujoco_30fps": 30, "c500c_30fps": 30}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a user's notes and an earlier report, after a quick run."""
    folder = tmp_path_factory.mktemp("follow")
    (folder / "notes.txt").write_text("mine")
    (folder / "report.json").write_text("earlier")
    run_experiment("follow", folder, quick=True)
    return folder


@pytest.fixture
def report(folder):
    return json.loads((folder / "report.json").read_text())


def test_the_folder_holds_report_plots_and_data_beside_what_was_there(folder):
    plots, data = (
        {"figure_6_15_positions.png", "figure_6_16_orientations.png"},
        {f"follow_{variant}.csv" for variant in VARIANTS},
    )
    assert {p.name for p in folder.iterdir()} == {"notes.txt", "report.json", "report.html"} | plots | data
    assert (folder / "notes.txt").read_text() == "mine"
    page = (folder / "report.html").read_text()
    assert all(name in page for name in plots | data)
    for name in plots:
        picture = present(cv2.imread(str(folder / name)))
        for curve in (TOOL, HAND_MEASURED):
            blue_green_red = [int(str(curve["color"])[k : k + 2], 16) for k in (5, 3, 1)]
            assert np.all(picture == blue_green_red, axis=2).sum() > 500


@pytest.mark.parametrize(("variant", "fps"), VARIANTS.items())
def test_the_data_has_a_row_for_every_frame(variant, fps, folder, report):
    table = np.genfromtxt(folder / f"follow_{variant}.csv", delimiter=",", names=True)
    assert len(present(table.dtype.names)) == 2 + 3 * 5 + 2
    assert (np.diff(table["frame"]) == 1).all()
    np.testing.assert_allclose(table["t_s"], table["frame"] / fps, atol=1e-3)
    assert table["t_s"][0] == pytest.approx(report[variant]["engaged_s"], abs=1e-3)
    assert table["tool_z_mm"].min() < -40.0


def test_the_mean_lags_by_half_its_window_and_farhand_far_less(report):
    mean, own = (report[variant]["tool_behind_true_hand"] for variant in ("mean_5fps", "kinematic_30fps"))
    assert mean["lag_ms"] == pytest.approx(800.0, abs=50.0)
    assert own["lag_ms"] < 0.2 * mean["lag_ms"]
    assert own["residual_mm"]["mean"] < 4.0
    assert own["residual_deg"]["xy_deg"]["mean"] < 3.0
    measured = report["kinematic_30fps"]["tool_behind_measured_hand"]
    assert measured["residual_mm"]["mean"] < 1.5
    assert [report[variant]["hindered"] for variant in VARIANTS] == [{}] * len(VARIANTS)


def test_each_robot_adds_its_own_lag_and_keeps_the_path(report):
    exact, physics, serial = (
        report[f"{robot}_30fps"]["tool_behind_true_hand"] for robot in ("kinematic", "mujoco", "c500c")
    )
    assert exact["lag_ms"] <= physics["lag_ms"] < exact["lag_ms"] + 40.0
    assert serial["lag_ms"] == pytest.approx(exact["lag_ms"] + 220.0, abs=60.0)
    assert max(physics["residual_mm"]["mean"], serial["residual_mm"]["mean"]) < exact["residual_mm"]["mean"] + 1.0


def test_the_gripper_is_measured_where_there_is_one(folder, report):
    openings = {name: report[name].get("gripper_mm", {}).get("at_first") for name in VARIANTS}
    assert openings == {"mean_5fps": None, "kinematic_30fps": None, "mujoco_30fps": 65.0, "c500c_30fps": 50.8}
    table = np.genfromtxt(folder / "follow_mujoco_30fps.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["gripper_mm"], 65.0, atol=0.1)


def test_the_same_film_is_measured_twice():
    config = SimulationConfig(motion=MotionConfig(name="reach_and_adjust", still_s=0.0))
    first, second = (film(config, TrackingConfig(), 10.0, 1.5, lambda: True).estimates for _ in range(2))
    assert [e.t_ns for e in first] == [k * 100_000_000 for k in range(16)]
    np.testing.assert_array_equal(first[-1].wrist, second[-1].wrist)


@pytest.mark.parametrize("name", ["calibration", "drift", "follow", "hazel", "icr", "markers"])
def test_an_interrupted_experiment_writes_nothing(name, tmp_path):
    with pytest.raises(InterruptionError, match=f"{name} was done; nothing of it was written"):
        run_experiment(name, tmp_path, quick=True, should_stop=lambda: True)
    assert list(tmp_path.iterdir()) == []


def test_misuse_is_refused_before_any_work(tmp_path):
    names = "all, calibration, causes, drift, follow, hazel, icr, markers, network, placing, realtime, robonaut"
    with pytest.raises(ConfigError, match=f"no experiment 'dance'; choose one of: {names}"):
        run_experiment("dance", tmp_path / "out", quick=True)
    assert not (tmp_path / "out").exists()
    taken = tmp_path / "taken"
    taken.write_text("mine")
    with pytest.raises(ConfigError, match="is a file; give a folder"):
        run_experiment("follow", taken, quick=True)
    with pytest.raises(ConfigError, match="taken is a file; give a folder"):
        run_experiment("follow", taken / "below", quick=True)


def test_a_file_that_cannot_take_its_place_leaves_what_is_there(tmp_path):
    (tmp_path / "report.json").mkdir()
    with pytest.raises(ConfigError, match="choose a folder that can be written"):
        write_result(tmp_path / "report.json", b"new")
    assert [p.is_dir() for p in tmp_path.iterdir()] == [True]
