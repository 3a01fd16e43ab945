"""What the tracking benchmark is measured on: simulated scenes and recordings with truth."""

import json
from itertools import islice
from typing import get_args

import cv2
import numpy as np
import pytest

from common.errors import CameraError
from lab.films.scenes import recorded, recorded_scenes, simulated, simulated_scenes
from local_site.calibration.triangulation import project
from local_site.simulation.cameras import control_point_rows
from local_site.simulation.config import MotionConfig, MotionName, SimulationConfig, StereoConfig
from tests.present import present

STEREO = StereoConfig(width_px=320, height_px=240, focal_px=400.0)
CONFIG = SimulationConfig(stereo=STEREO, motion=MotionConfig(name="figure_of_eight", still_s=0.0))
POINT = [0.5, 0.45, 0.5]


def write_recording(folder, frames, truths):
    folder.mkdir()
    (folder / "control_points.csv").write_text("\n".join(control_point_rows(STEREO, 0.1, seed=1)))
    for side in ("left", "right"):
        writer = cv2.VideoWriter(str(folder / f"{side}.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 15.0, (320, 240))
        for k in range(frames):
            writer.write(np.full((240, 320, 3), 20 * k, np.uint8))
        writer.release()
    line = {"frame": 0, "hand_open": True} | dict.fromkeys(("elbow", "wrist", "index", "thumb"), POINT)
    (folder / "truth.jsonl").write_text("".join(json.dumps(line) + "\n" for _ in range(truths)))


def test_every_motion_and_other_bodies_are_there():
    names = [scene.name for scene in simulated_scenes()]
    assert {f"simulated {motion}" for motion in get_args(MotionName)} < set(names)
    assert len(names) == len(set(names)) == len(get_args(MotionName)) + 2


def test_the_truth_of_a_simulated_instant_lies_on_the_arm_in_its_pictures():
    scene = simulated("one", CONFIG, 0.2)
    instants = list(scene.instants())
    assert [i.views.t_ns for i in instants] == [round(k * 1e9 / 30) for k in range(6)]
    for view, matrix in zip(instants[3].views.views, scene.rig.matrices, strict=True):
        x, y = np.round(project(matrix, present(instants[3].truth).wrist)).astype(int)
        assert view.current.image[y, x] > 2 * np.median(view.current.image)


def test_instants_begin_anew_each_time():
    scene = simulated("one", CONFIG, 1.0)
    first, again = (next(islice(scene.instants(), 2, None)) for _ in range(2))
    assert np.array_equal(first.views.views[0].current.image, again.views.views[0].current.image)


def test_recordings_are_found_with_their_rig_and_truth(tmp_path):
    write_recording(tmp_path / "b", 3, 3)
    write_recording(tmp_path / "a", 2, 2)
    scenes = recorded_scenes(tmp_path)
    assert [scene.name for scene in scenes] == ["a", "b"]
    instants = list(scenes[1].instants())
    assert len(instants) == 3
    assert scenes[1].methods == ("silhouette", "learned")
    assert present(instants[2].truth).index == pytest.approx(POINT)
    assert present(instants[2].truth).hand_open
    assert [v.current.image.mean() for v in instants[2].views.views] == pytest.approx([40, 40], abs=2)


@pytest.mark.parametrize(("frames", "truths"), [(2, 3), (3, 2)])
def test_a_recording_whose_truth_does_not_fit_is_refused(frames, truths, tmp_path):
    write_recording(tmp_path / "odd", frames, truths)
    with pytest.raises(CameraError, match="lines of truth"):
        list(recorded(tmp_path / "odd").instants())
