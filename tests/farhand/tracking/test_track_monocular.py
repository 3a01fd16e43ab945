"""Tracking one camera from the command line: its options, its lines, and what it refuses."""

import json

import cv2
import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

from common.config.loading import load_config
from common.errors import ConfigError, TrackingError
from farhand.cli import app
from farhand.tracking.track_run import joint_settings
from local_site.calibration.rig_file import save_rig
from local_site.config import LocalConfig
from local_site.simulation.hazel import Swing, film_camera, film_pixel, hazel_film
from local_site.simulation.textured_arm import Scenery

FRAMES = 5


@pytest.fixture
def folder(tmp_path):
    """Pictures of the swinging arm, and a rig of two cameras of which the left one films it."""
    film, swing = hazel_film(), Swing(speed=3.0)
    (tmp_path / "pictures").mkdir()
    for k in range(FRAMES):
        cv2.imwrite(str(tmp_path / "pictures" / f"{k:03d}.png"), film.render(swing.arm(k).limb_poses()))
    one = film_camera()
    (left,) = one.cameras
    first, *others = left.projection
    beside = (*first[:3], -0.3 * first[0]), *others
    right = msgspec.structs.replace(left, name="right", projection=beside)
    save_rig(msgspec.structs.replace(one, cameras=(left, right)), tmp_path / "rig.json")
    return tmp_path


def run(folder, *more):
    return CliRunner().invoke(app, ["track", "--rig", str(folder / "rig.json"), *more])


def test_one_camera_is_tracked_from_the_joints_that_are_given(folder):
    first, last = Swing(speed=3.0).arm(0), Swing(speed=3.0).arm(FRAMES - 1)
    joints = " ".join(f"{x},{y}" for x, y in (film_pixel(p) for p in (first.shoulder, first.elbow, first.wrist)))
    options = ["--fps", "30", "--joints", joints, "--out", str(folder / "track.jsonl")]
    done = run(folder, "--monocular", str(folder / "pictures"), *options)
    assert done.exit_code == 0, done.exception
    assert f"{FRAMES} tracked" in done.output
    lines = [json.loads(line) for line in (folder / "track.jsonl").read_text().splitlines()]
    assert len(lines) == FRAMES
    np.testing.assert_allclose(lines[-1]["wrist"], last.wrist, atol=0.003)
    np.testing.assert_allclose(lines[-1]["palm"], last.along_forearm(0.255 + 0.060), atol=0.004)
    assert lines[-1]["index"] is None
    assert "index and thumb are not measured" in lines[-1]["reason"]


@pytest.mark.slow
def test_an_arm_before_a_dark_wall_is_found_by_its_silhouette(folder):
    film, swing = hazel_film(Scenery(wall=20.0, wall_relief=3.0)), Swing(speed=3.0)
    for k in range(FRAMES):
        cv2.imwrite(str(folder / "pictures" / f"{k:03d}.png"), film.render(swing.arm(k).limb_poses()))
    options = ["--fps", "30", "--joints", "silhouette", "--out", str(folder / "track.jsonl")]
    done = run(folder, "--monocular", str(folder / "pictures"), *options)
    first, *others = [json.loads(line) for line in (folder / "track.jsonl").read_text().splitlines()]
    assert first["status"] in ("tracked", "degraded"), done.output  # by the processor's rounding
    assert [line["status"] for line in others] == ["tracked"] * (FRAMES - 1), done.output
    last = others[-1]
    np.testing.assert_allclose(last["wrist"], swing.arm(FRAMES - 1).wrist, atol=0.030)


@pytest.mark.slow
def test_before_a_bright_wall_the_silhouette_is_not_guessed(folder):
    done = run(
        folder,
        "--monocular",
        str(folder / "pictures"),
        "--fps",
        "30",
        "--joints",
        "silhouette",
        "--out",
        str(folder / "t"),
    )
    assert isinstance(done.exception, TrackingError)
    assert "darken the background" in str(done.exception)
    assert len((folder / "t").read_text().splitlines()) == FRAMES


def test_joints_on_the_command_line_come_before_a_silhouette_in_a_file():
    site = load_config(LocalConfig, None, [*joint_settings("silhouette"), *joint_settings("1,2 3,4 5,6")])
    start = site.tracking.monocular.start
    assert (start.by, start.elbow_px) == ("joints", (3.0, 4.0))


def test_options_that_contradict_each_other_are_refused(folder):
    assert isinstance(run(folder, "--monocular", "a", "--left", "b").exception, ConfigError)
    assert isinstance(run(folder, "--left", "b").exception, ConfigError)
    beyond = run(folder, "--monocular", "a", "--set", "tracking.monocular.camera=3")
    assert "the rig has 2 cameras" in str(beyond.exception)


@pytest.mark.parametrize("text", ["", "1,2 3,4", "1,2 3,4 5", "1,2 3,4 five,6"])
def test_joints_must_be_three_pixels(text):
    with pytest.raises(ConfigError, match="'x,y x,y x,y'"):
        joint_settings(text)
