"""`farhand track` as a person runs it: how it ends, what it then leaves, and how far it says it is."""

import csv
import json
import sys
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from common.errors import TrackingError
from common.messages.hand import TrackingStatus
from farhand.calibration.points import calibrate_points
from farhand.cli import main
from farhand.tracking.summary import Summary, refuse_nothing
from local_site.calibration.rig_file import save_rig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.tracker import TrackingReason
from tests.farhand.tracking.results.tracked import pair as tracked_pair

DATA = Path(__file__).parents[4] / "shared/data/recordings"
RESULTS = ("track.jsonl", "track.csv", "overlay.mp4", "report/report.html")
EXCHANGED = "the views do not fit together: out of sync, exchanged, or moved since calibration"


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: str | int | None
    out: str
    err: str


@pytest.fixture
def track(monkeypatch, capsys, tmp_path):
    """Runs the command in an empty folder, which has a rig."""
    monkeypatch.chdir(tmp_path)
    save_rig(exact_rig(StereoConfig()), tmp_path / "rig.json")

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["farhand", "track", "--rig", "rig.json", *map(str, arguments)])
        code: str | int | None = 0
        try:
            main()
        except SystemExit as ended:
            code = ended.code
        told = capsys.readouterr()
        return Ended(code, told.out, told.err)

    return run


def everything():
    """The options for all results."""
    out, table, video, page = RESULTS
    return ["--out", out, "--csv", table, "--video", video, "--report", Path(page).parent]


def dark(folder, count):
    """A folder of dark pictures."""
    folder.mkdir()
    for k in range(count):
        cv2.imwrite(str(folder / f"{k:03d}.png"), np.full((48, 64), 8 + len(folder.name), np.uint8))
    return folder


def test_where_nothing_was_tracked_the_command_fails_and_keeps_what_it_wrote(track, tmp_path):
    left, right = dark(tmp_path / "left", 4), dark(tmp_path / "right", 5)
    done = track("--left", left, "--right", right, "--tracker", "markers", *everything())
    assert done.code == 1
    assert done.err.splitlines()[-1].startswith("farhand: nothing was tracked; most often: ")
    assert "4 pairs: 4 lost" in done.out
    assert "written to track.jsonl, track.csv, overlay.mp4, report/report.html" in done.out
    assert "warning: left ended after 4 pairs" in done.out
    assert len((tmp_path / "track.jsonl").read_text().splitlines()) == 4
    assert len((tmp_path / "track.csv").read_text().splitlines()) == 5
    assert cv2.VideoCapture(str(tmp_path / "overlay.mp4")).get(cv2.CAP_PROP_FRAME_COUNT) == 4
    assert "4 pairs" in (tmp_path / "report/report.html").read_text()


def test_a_rig_that_cannot_be_used_is_named_by_the_option(track, tmp_path):
    (tmp_path / "rig.json").write_text("{}")
    done = track("--left", "left", "--right", "right")
    assert done.code == 1
    assert "name it in --rig" in done.err
    assert "operator.rig" not in done.err


def test_the_bar_ends_at_the_number_of_pairs_of_the_shortest_recording(track, tmp_path):
    left, right = dark(tmp_path / "left", 6), dark(tmp_path / "right", 4)
    assert "4/4" in track("--left", left, "--right", right, "--tracker", "markers").err


def test_a_video_that_cannot_be_made_leaves_earlier_results_alone(track, tmp_path, monkeypatch):
    left, right = dark(tmp_path / "left", 2), dark(tmp_path / "right", 2)
    for name in RESULTS[:3]:
        (tmp_path / name).write_text("earlier\n")
    monkeypatch.setattr("farhand.tracking.results.video.CODEC", "none")
    done = track("--left", left, "--right", right, "--tracker", "markers", *everything())
    assert (done.code, "pip install opencv-python-headless" in done.err) == (2, True)
    assert [(tmp_path / name).read_text() for name in RESULTS[:3]] == ["earlier\n"] * 3
    assert not (tmp_path / "report").exists()


def test_a_live_camera_needs_a_rate_for_the_video(track, monkeypatch):
    class Live:
        """A camera without a rate."""

        def __init__(self, name):
            self.name = name

        def close(self):
            pass

    monkeypatch.setattr("farhand.tracking.track_run.open_rig_cameras", lambda *_: [Live("left"), Live("right")])
    done = track("--left", "0", "--right", "1", "--video", "overlay.mp4")
    assert done.code == 2
    assert "live cameras do not state their frame rate; give it with --fps" in done.err


LEARNING = f"{TrackingReason.LEARNING} (3 of 10 pairs)"


@pytest.mark.parametrize(
    ("pairs", "fails"),
    [
        ([(TrackingStatus.LOST, "too dark")] * 3, True),
        ([(TrackingStatus.LOST, "too dark")] * 2 + [(TrackingStatus.INITIALISING, LEARNING)], True),
        ([(TrackingStatus.LOST, "too dark")] * 2 + [(TrackingStatus.DEGRADED, LEARNING)], True),
        ([(TrackingStatus.LOST, "too dark")] * 2 + [(TrackingStatus.DEGRADED, "folded")], False),
        ([(TrackingStatus.LOST, "too dark")] * 2 + [(TrackingStatus.TRACKED, "")], False),
        ([], False),
    ],
)
def test_degraded_pairs_count_as_tracked_and_those_in_which_the_arm_is_learned_do_not(pairs, fails):
    summary = Summary()
    for k, (status, reason) in enumerate(pairs):
        summary.add(tracked_pair(k, status=status, reason=reason).line)
    refused = pytest.raises(TrackingError, match="nothing was tracked; most often: too dark")
    with refused if fails else nullcontext():
        refuse_nothing(summary)


@pytest.mark.parametrize(
    ("seen", "told"),
    [
        (2, "after 2 of 6 pairs; what was tracked so far is written to track.jsonl, track.csv"),
        (0, "before the first pair; nothing was written"),
    ],
)
def test_a_track_that_a_person_stops_says_how_far_it_came_and_what_is_kept(track, tmp_path, monkeypatch, seen, told):
    asked = iter([False] * seen)
    monkeypatch.setattr("farhand.commands.track.until_signal", lambda: lambda: next(asked, True))
    left, right = dark(tmp_path / "left", 6), dark(tmp_path / "right", 6)
    done = track("--left", left, "--right", right, "--tracker", "markers", "--csv", "track.csv")
    assert (done.code, done.err.splitlines()[-1]) == (130, f"farhand: stopped by Ctrl-C or SIGTERM {told}")
    assert (tmp_path / "track.jsonl").exists() == (seen > 0)


@pytest.mark.slow
@pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")
@pytest.mark.parametrize("exchanged", [False, True])
def test_an_exchanged_pair_is_told_by_the_exit_code(track, tmp_path, exchanged):
    calibrate_points(DATA / "yz/control_points.csv", tmp_path / "rig.json")
    left, right = (DATA / "yz" / f"{name}.avi" for name in ("left", "right"))
    pair = ("--left", right, "--right", left) if exchanged else ("--left", left, "--right", right)
    done = track(*pair, *everything())
    lines = [json.loads(line) for line in (tmp_path / "track.jsonl").read_text().splitlines()]
    with (tmp_path / "track.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(lines) == len(rows) == cv2.VideoCapture(str(tmp_path / "overlay.mp4")).get(cv2.CAP_PROP_FRAME_COUNT)
    assert f"{len(lines)}/{len(lines)}" in done.err
    if exchanged:
        assert (done.code, done.err.splitlines()[-1]) == (
            1,
            f"farhand: nothing was tracked; most often: {EXCHANGED}",
        )
        return
    assert done.code == 0
    found = [(row, line) for row, line in zip(rows, lines, strict=True) if line["wrist"]]
    assert len(found) > 60
    assert all([float(row[f"wrist_{a}_m"]) for a in "xyz"] == line["wrist"] for row, line in found)


@pytest.mark.slow
@pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")
def test_the_file_of_another_rig_is_told_in_the_closing_sentence(track):
    pair = [f"--{name}={DATA / 'yz' / name}.avi" for name in ("left", "right")]
    done = track(*pair)
    assert done.out.splitlines()[-1].startswith("warning: the views miss each other by ")
    assert done.out.rstrip().endswith("calibrate again, or give the file of this rig")
