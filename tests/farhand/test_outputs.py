"""Results never replace what they come from, and a failure leaves earlier results alone."""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from msgspec.structs import replace
from typer.testing import CliRunner

from common.cameras.camera import Frame
from common.errors import ConfigError, FarhandError
from farhand.calibration.points import doubts, solvable
from farhand.cli import app
from farhand.outputs import check_file, check_folder, make_folder, written_at_end
from farhand.tracking.results.outputs import json_lines
from farhand.tracking.track import track_recording
from local_site.calibration.rig_file import save_rig
from local_site.simulation.cameras import calibrate_simulated, control_point_rows
from local_site.simulation.config import SimulationConfig, StereoConfig
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import View, Views


class Blank:
    """A camera of black pictures that fails after some."""

    def __init__(self, name, pictures, fails):
        self.name, self._left, self._fails, self._seq = name, pictures, fails, 0

    def read(self):
        if not self._left:
            if self._fails:
                raise OSError("the disk is gone")
            return None
        self._left, self._seq = self._left - 1, self._seq + 1
        return Frame(np.zeros((48, 64), np.uint8), self._seq * 10**7, self._seq)

    def close(self):
        pass


def test_an_output_over_an_input_is_refused(tmp_path):
    csv = tmp_path / "points.csv"
    csv.write_text("\n".join(control_point_rows(StereoConfig(), 0.3, seed=1)))
    before = csv.read_text()
    with pytest.raises(ConfigError, match="choose another name"):
        check_file("--out", csv, [csv])
    result = CliRunner().invoke(app, ["calibrate", "points", str(csv), "--out", str(csv)])
    assert isinstance(result.exception, ConfigError)
    assert csv.read_text() == before


def test_a_track_over_its_rig_is_refused(tmp_path):
    rig = tmp_path / "rig.json"
    save_rig(calibrate_simulated(SimulationConfig()), rig)
    arguments = ["track", "--rig", str(rig), "--left", "a.avi", "--right", "b.avi", "--out", str(rig)]
    assert isinstance(CliRunner().invoke(app, arguments).exception, ConfigError)


@pytest.mark.parametrize("out", [".", "absent/track.jsonl"])
def test_a_file_that_cannot_be_written_is_refused_before_any_work(tmp_path, out):
    with pytest.raises(ConfigError, match=r"--out .*: give a file in a folder that exists"):
        check_file("--out", tmp_path / out)


@pytest.mark.parametrize("source", ["pictures", "pictures/*.png", "pictures/000000.png"])
def test_drawn_pictures_never_go_where_pictures_are_read(tmp_path, source):
    (tmp_path / "pictures").mkdir()
    (tmp_path / "pictures" / "000000.png").touch()
    with pytest.raises(ConfigError, match=r"--annotate .* would overwrite what is read"):
        check_folder("--annotate", tmp_path / "pictures", [tmp_path / source])
    check_folder("--annotate", tmp_path / "other", [tmp_path / source])
    with pytest.raises(ConfigError, match="is a file; give a folder"):
        check_folder("--annotate", tmp_path / "pictures" / "000000.png")


def test_a_folder_below_a_file_is_refused_before_any_work(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=r"--save-views .*file is a file; give a folder"):
        check_folder("--save-views", tmp_path / "file" / "views" / "today")
    check_folder("--save-views", tmp_path / "views" / "today")


@pytest.mark.parametrize("make", [check_folder, make_folder])
def test_what_the_file_system_refuses_is_refused_before_any_work(make):
    with pytest.raises(ConfigError, match=r"--report .* cannot be written; choose another file"):
        check_file("--report", Path("/proc/report.json"))
    with pytest.raises(ConfigError, match=r"--report /proc/views.* cannot be (written|made).*; choose another folder"):
        make("--report", Path("/proc/views"))


def test_an_output_may_be_a_device_or_a_link_and_the_trial_leaves_nothing(tmp_path):
    check_file("--out", Path(os.devnull))
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "folder" / "track.jsonl")
    check_file("--out", tmp_path / "link")
    check_folder("--report", tmp_path / "folder" / "report")
    assert not list((tmp_path / "folder").iterdir())


@pytest.mark.parametrize(("pictures", "kept"), [(0, True), (3, False)])
def test_an_earlier_track_is_replaced_only_by_a_new_one(tmp_path, pictures, kept):
    out = tmp_path / "track.jsonl"
    out.write_text("earlier\n")
    rig = calibrate_simulated(SimulationConfig())
    cameras = Blank("left", pictures, fails=False), Blank("right", max(pictures - 1, 0), fails=True)
    with pytest.raises(FarhandError):
        track_recording(rig, cameras[0], cameras[1:], [json_lines(out)], lambda _: None)
    assert (out.read_text() == "earlier\n") is kept
    assert list(tmp_path.iterdir()) == [out]


def test_a_last_line_that_found_no_room_is_cut(tmp_path):
    out = tmp_path / "track.jsonl"
    with written_at_end(out) as lines:
        lines.write('{"frame":0}\n{"fra')
    assert out.read_text() == '{"frame":0}\n'
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("singular"), cv2.error("findHomography")])
def test_equations_without_a_solution_are_told_with_their_cure(error):
    with pytest.raises(FarhandError, match="check the plate's size"), solvable():
        raise error


def test_points_that_cannot_be_in_mm_are_doubted():
    rig = calibrate_simulated(SimulationConfig())
    assert doubts(rig) == []
    shrunk = replace(rig, volume_max=tuple(low + 1e-3 for low in rig.volume_min))
    assert "given in mm" in doubts(shrunk)[0]


def test_pictures_of_another_size_than_calibrated_are_told():
    rig = calibrate_simulated(SimulationConfig())
    sized = replace(rig, cameras=tuple(replace(camera, size_px=(640, 480)) for camera in rig.cameras))
    frames = tuple(View(Frame(np.zeros((240, 320), np.uint8), 0, 0)) for _ in sized.cameras)
    reason = SilhouetteTracker(sized).track(Views(0, frames)).reason
    assert "the picture is 320x240, but was calibrated at 640x480" in reason
