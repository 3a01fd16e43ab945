"""The tracker on recordings of an arm with known truth: how much of them it follows, how closely, and the toggles."""

import json
from pathlib import Path

import numpy as np
import pytest

from common.cameras.sources import open_camera
from farhand.calibrate import calibrate_points
from farhand.track import track_recording

DATA = Path(__file__).parents[4] / "shared/data/recordings"
SETTLED = 10

pytestmark = pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")


def tracked(name, tmp_path):
    """The lines of a tracked recording and of its truth, after the first frames."""
    folder = DATA / name
    rig = calibrate_points(folder / "control_points.csv", tmp_path / "rig.json")
    cameras = [open_camera(str(folder / f"{side}.avi"), side) for side in ("left", "right")]
    counted = []
    summary = track_recording(rig, cameras[0], cameras[1], tmp_path / "track.jsonl", None, counted.append)
    for camera in cameras:
        camera.close()
    lines = [json.loads(line) for line in (tmp_path / "track.jsonl").read_text().splitlines()]
    truth = [json.loads(line) for line in (folder / "truth.jsonl").read_text().splitlines()]
    assert counted == list(range(1, len(truth) + 1))
    assert summary.pairs == len(lines) == len(truth)
    return lines[SETTLED:], truth[SETTLED:]


def mean_error_mm(lines, truth, name):
    pairs = [(line[name], true[name]) for line, true in zip(lines, truth, strict=True) if line[name] is not None]
    return 1e3 * np.mean([np.linalg.norm(np.subtract(*pair)) for pair in pairs])


@pytest.mark.parametrize(("name", "toggles"), [("yz", 0), ("icr_elbow", 0), ("pick", 2), ("toggle", 4)])
def test_recordings_are_followed_and_openings_counted(name, toggles, tmp_path):
    lines, truth = tracked(name, tmp_path)
    complete = [all(line[point] is not None for point in ("elbow", "wrist", "index")) for line in lines]
    assert np.mean(complete) >= 0.95
    assert lines[-1]["gripper_toggles"] == toggles
    assert mean_error_mm(lines, truth, "elbow") < 15
    assert mean_error_mm(lines, truth, "wrist") < 8


@pytest.mark.parametrize(("name", "index_mm", "thumb_mm"), [("yz", 10, 6), ("icr_elbow", 12, 8)])
def test_index_and_thumb_are_followed_while_the_grip_is_held(name, index_mm, thumb_mm, tmp_path):
    lines, truth = tracked(name, tmp_path)
    assert mean_error_mm(lines, truth, "index") < index_mm
    assert mean_error_mm(lines, truth, "thumb") < thumb_mm
