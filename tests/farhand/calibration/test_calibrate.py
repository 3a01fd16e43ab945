"""The calibrate commands: what they print, write and refuse, each refusal with its cure."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from common.errors import CalibrationError, ConfigError, FarhandError, InterruptionError
from farhand.calibration.boards import calibrate_board_pictures, calibrate_live, make_board
from farhand.calibration.pictures import PictureJob, by_name, calibrate_plate, parse_heights, read_pictures
from farhand.calibration.points import calibrate_points, describe, parse_pair
from farhand.cli import app
from local_site.calibration.boards import BoardFinder
from local_site.calibration.plate import Plate
from local_site.calibration.rig_file import load_rig
from local_site.simulation.cameras import control_point_rows
from local_site.simulation.config import StereoConfig
from tests.present import present

DATA = Path(__file__).parents[4] / "shared/data/recordings"
RECORDED = pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")
BOARD = make_board("chessboard", (7, 5), 40.0, 0.0, "")
POSES = (
    (0, 0, 0, 0.0, 0.0, 0.0),
    (30, 0, 5, 0.08, 0.04, 0.0),
    (-30, 10, 0, -0.08, 0.05, 0.05),
    (0, 30, -5, -0.07, -0.06, 0.0),
    (10, -30, 0, 0.08, -0.05, 0.05),
    (25, 25, 10, 0.0, 0.07, -0.05),
)


def write_points(tmp_path, noise=0.3, **stereo):
    path = tmp_path / "points.csv"
    path.write_text("\n".join(control_point_rows(StereoConfig(**stereo), noise, seed=1)))
    return path


def unseen(_what, _done, _total):
    """Progress that nobody watches."""


def run(*arguments):
    return CliRunner().invoke(app, ["calibrate", *map(str, arguments)])


def test_points_give_a_rig_file_with_all_that_is_to_be_known(tmp_path):
    out = tmp_path / "rig.json"
    csv = write_points(tmp_path, k1=-0.1)
    result = run("points", csv, "--out", out, "--size", "640x480", "--serial", "left=A1")
    assert result.exit_code == 0, result.output
    for words in (
        "reprojection rms: left 0.",
        "3D error rms: X ",
        "each left out in turn: X",
        "k1 p = ",
        "rig written",
    ):
        assert words in result.output
    rig = load_rig(out)
    assert [camera.serial for camera in rig.cameras] == ["A1", ""]
    assert [camera.size_px for camera in rig.cameras] == [(640, 480)] * 2
    assert all(camera.lens is not None for camera in rig.cameras)
    assert rig.leave_one_out_rms is not None
    assert rig.created.startswith("20")
    assert json.loads(out.read_bytes())["cameras"][0]["lens"]["k1"] == pytest.approx(-0.1, abs=0.03)


@pytest.mark.parametrize("command", ["points", "images", "live"])
def test_a_rig_file_that_exists_is_never_replaced(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    Path("rig.json").write_text("an earlier rig")
    given = [write_points(tmp_path)] if command == "points" else ["--left", "a", "--right", "b"]
    refused = run(command, *given).exception
    assert isinstance(refused, ConfigError)
    assert "--out rig.json exists already; give another name, or move it away first" in str(refused)
    assert Path("rig.json").read_text() == "an earlier rig"


def test_a_poorly_covered_picture_is_warned_of(tmp_path):
    csv = write_points(tmp_path, distance_m=5.0)
    words = describe(calibrate_points(csv, tmp_path / "rig.json", size=(640, 480)))
    assert "warning: left camera: the points cover" in words


@pytest.mark.parametrize("serials", [["middle=1"], ["left"], ["left="]])
def test_serials_of_unknown_cameras_are_refused(tmp_path, serials):
    with pytest.raises(ConfigError, match="NAME one of left, right"):
        calibrate_points(write_points(tmp_path), tmp_path / "rig.json", serials=serials)


@pytest.mark.parametrize("text", ["640", "640x", "x", "0x5", "-4x5", "640x480x2", "999999999x2"])
def test_sizes_that_are_none_are_refused(text):
    with pytest.raises(ConfigError, match="--size"):
        parse_pair(text, "--size")


@pytest.mark.parametrize("text", ["", "0", "0,0", "a,b", "0,inf", "0,,5"])
def test_heights_that_are_none_are_refused(text):
    with pytest.raises(ConfigError, match="--heights-mm"):
        parse_heights(text)


@RECORDED
def test_pictures_of_the_recorded_plate_give_a_rig(tmp_path):
    out, found = tmp_path / "rig.json", tmp_path / "found"
    sources = [f"--{side}={DATA}/calib_{side}_*.png" for side in ("left", "right")]
    result = run("images", *sources, "--out", out, "--pictures", found)
    assert result.exit_code == 0, result.output
    assert np.linalg.norm(present(load_rig(out).leave_one_out_rms)) < 0.0002
    assert sorted(path.name for path in found.iterdir()) == sorted(
        f"{side}_{name}.png" for side in ("left", "right") for name in (1, 2, 3, "coverage")
    )


@RECORDED
def test_exchanged_and_miscounted_pictures_of_a_plate_are_refused(tmp_path):
    left, right = (f"{DATA}/calib_{side}_*.png" for side in ("left", "right"))
    with pytest.raises(CalibrationError, match="exchange the two"):
        calibrate_plate(PictureJob({"left": right, "right": left}, tmp_path / "rig.json"), Plate(), (0.0, 0.497, 0.994))
    with pytest.raises(CalibrationError, match="3 pictures for 2 heights"):
        calibrate_plate(PictureJob({"left": left, "right": right}, tmp_path / "rig.json"), Plate(), (0.0, 0.497))


@RECORDED
def test_mirrored_pictures_of_a_plate_are_refused(tmp_path):
    for side in ("left", "right"):
        for k in range(3):
            picture = present(cv2.imread(str(DATA / f"calib_{side}_{k}.png")))
            cv2.imwrite(str(tmp_path / f"{side}_{k}.png"), picture[:, ::-1])
    sources = {side: str(tmp_path / f"{side}_*.png") for side in ("left", "right")}
    with pytest.raises(CalibrationError, match="mirroring of both"):
        calibrate_plate(PictureJob(sources, tmp_path / "rig.json"), Plate(), (0.0, 0.497, 0.994))


def board_picture(pose, side):
    """A chessboard in one of the poses, as the camera on the left (-1) or right (1) sees it."""
    squares = np.kron(np.indices((5, 7)).sum(axis=0) % 2, np.ones((48, 48))) * 200 + 20
    picture = cv2.copyMakeBorder(squares.astype(np.uint8), 48, 48, 48, 48, cv2.BORDER_CONSTANT, value=220)
    turn = Rotation.from_euler("y", 20 * side, degrees=True).as_matrix()
    tilt, middle = Rotation.from_euler("xyz", pose[:3], degrees=True).as_matrix(), np.array(pose[3:])
    corner = turn @ (middle - tilt @ BOARD.middle) + (0.0, 0.0, 0.9)
    lens = np.array([[1200.0, 0.0, 480.0], [0.0, 1200.0, 360.0], [0.0, 0.0, 1.0]])
    pixel_H_board = lens @ np.column_stack([turn @ tilt[:, :2], corner])
    board_H_print = np.array(
        [[1 / 1200, 0.0, -0.04 + 0.5 / 1200], [0.0, 1 / 1200, -0.04 + 0.5 / 1200], [0.0, 0.0, 1.0]]
    )
    fine = cv2.warpPerspective(picture, pixel_H_board @ board_H_print, (960, 720), borderValue=40)
    return cv2.resize(fine, (320, 240), interpolation=cv2.INTER_AREA)


def board_folders(tmp_path, repeats=1):
    """A folder of pictures for each camera, each pose held for this many pictures."""
    sources = {}
    for side, name in ((-1, "left"), (1, "right")):
        folder = tmp_path / name
        folder.mkdir()
        for k, pose in enumerate(pose for pose in POSES for _ in range(repeats)):
            cv2.imwrite(str(folder / f"{k:03d}.png"), board_picture(pose, side))
        sources[name] = str(folder)
    return sources


def test_a_live_board_is_taken_once_per_pose_drawn_and_solved(tmp_path, monkeypatch):
    find, found_in = BoardFinder.find, {}

    def find_once(finder, picture):
        """A board that is held still gives the same picture several times."""
        key = picture.tobytes()
        if key not in found_in:
            found_in[key] = find(finder, picture)
        return found_in[key]

    monkeypatch.setattr(BoardFinder, "find", find_once)
    sources, found, said = board_folders(tmp_path, repeats=6), tmp_path / "found", list[str]()
    job = PictureJob(sources, tmp_path / "rig.json", found)
    rig = calibrate_live(job, BOARD, True, len(POSES), lambda: False, said.append).rig
    assert load_rig(tmp_path / "rig.json") == rig
    assert np.linalg.norm(rig.error_rms) < 0.0005
    centres = [-np.linalg.solve(m[:, :3], m[:, 3]) for m in rig.matrices]
    assert np.linalg.norm(centres[1] - centres[0]) == pytest.approx(2 * 0.9 * np.sin(np.radians(20)), abs=0.005)
    assert len(said) == len(POSES)
    assert said[0].startswith("pose 1: left 24 corners, ")
    assert said[-1].endswith("0 to go, move the board")
    names = {path.name for path in found.iterdir()}
    assert {"left_1.png", f"right_{len(POSES)}.png", "left_coverage.png", "right_coverage.png"} <= names


def test_a_live_run_without_a_board_or_stopped_at_once_says_so(tmp_path):
    (tmp_path / "dark").mkdir()
    cv2.imwrite(str(tmp_path / "dark" / "0.png"), np.zeros((48, 64), np.uint8))
    sources = {"left": str(tmp_path / "dark"), "right": str(tmp_path / "dark")}
    job = PictureJob(sources, tmp_path / "r.json")
    with pytest.raises(CalibrationError, match="hold it still for a moment"):
        calibrate_live(job, BOARD, False, 5, lambda: False, print)
    with pytest.raises(InterruptionError, match="before a pose"):
        calibrate_live(job, BOARD, False, 5, lambda: True, print)


def test_pictures_without_the_board_are_refused_by_their_camera(tmp_path):
    sources = board_folders(tmp_path)
    (tmp_path / "dark").mkdir()
    for k in range(len(POSES)):
        cv2.imwrite(str(tmp_path / "dark" / f"{k}.png"), np.zeros((480, 640), np.uint8))
    job = PictureJob({**sources, "right": str(tmp_path / "dark")}, tmp_path / "rig.json")
    with pytest.raises(CalibrationError, match=r"camera right: none of its 6 pictures shows the board; check --board"):
        calibrate_board_pictures(job, BOARD, False, unseen)


def test_every_picture_counts_in_the_progress_and_the_total_is_known_from_the_start(tmp_path):
    told = []
    sources = board_folders(tmp_path)
    calibrate_board_pictures(
        PictureJob(sources, tmp_path / "rig.json"), BOARD, True, lambda *progress: told.append(progress)
    )
    count = 2 * len(POSES)
    assert told[: count + 1] == [("looking for the board", k, count) for k in range(count + 1)]
    assert told[count + 1 :] == [("solving the cameras", 0, None), ("solving the cameras", 1, 1)]


def test_unequal_counts_and_sizes_of_pictures_are_refused(tmp_path):
    sources = board_folders(tmp_path)
    first = tmp_path / "right" / "000.png"
    cv2.imwrite(str(first), np.zeros((48, 64), np.uint8))
    with pytest.raises(CalibrationError, match="camera right: its pictures differ in size"):
        calibrate_board_pictures(PictureJob(sources, tmp_path / "rig.json"), BOARD, False, unseen)
    first.unlink()
    with pytest.raises(CalibrationError, match=r"different numbers of pictures.*left 6, right 5"):
        calibrate_board_pictures(PictureJob(sources, tmp_path / "rig.json"), BOARD, False, unseen)


def test_sources_are_named_in_order_and_missing_ones_refused(tmp_path):
    assert by_name(("a", "b", "c", None)) == {"left": "a", "right": "b", "third": "c"}
    with pytest.raises(ConfigError, match="--left, --right, --third, --fourth"):
        by_name(("a", "b", None, "d"))
    with pytest.raises(FarhandError, match="no file matches"):
        read_pictures(str(tmp_path / "*.png"), "left")
    with pytest.raises(FarhandError, match="does not exist; give a folder"):
        read_pictures(str(tmp_path / "absent"), "left")
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises(FarhandError, match="not an image that can be read"):
        read_pictures(str(tmp_path / "text.png"), "left")


def test_an_unknown_board_is_refused():
    with pytest.raises(ConfigError, match="--board must be charuco or chessboard"):
        make_board("circles", (8, 6), 30.0, 22.0, "5X5_250")
