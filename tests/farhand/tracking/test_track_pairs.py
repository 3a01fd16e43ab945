"""Pairing two recordings by capture time, and what an empty or unwritable track says."""

import dataclasses
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from msgspec.structs import replace

from common.cameras.camera import Frame
from common.errors import CameraError, ConfigError
from common.messages.hand import TrackingStatus
from farhand.tracking.recorded_pairs import RecordedPairs
from farhand.tracking.results.outputs import TrackOutputs, annotated_pictures, json_lines
from farhand.tracking.summary import describe
from farhand.tracking.track import track_recording
from farhand.tracking.track_run import TrackSources, run_track
from local_site.calibration.control_points import CAMERAS
from local_site.calibration.rig import Rig
from local_site.calibration.rig_file import save_rig
from local_site.config import LocalConfig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.annotate import LINE_HEIGHT_PX
from local_site.tracking.choice import TrackingConfig
from tests.present import present

IMAGE = np.full((48, 64), 8, np.uint8)


class Recording:
    """Dark frames at given times."""

    def __init__(self, *times_ns, name="camera"):
        self.name = name
        self._frames = iter([Frame(IMAGE, t, k) for k, t in enumerate(times_ns)])

    def read(self):
        return next(self._frames, None)

    def close(self):
        pass


def test_synchronous_frames_are_paired_as_they_are():
    views = list(RecordedPairs(Recording(0, 10, 20), Recording(0, 10, 20)))
    assert [(v.t_ns, v.views[1].current.capture_ns, v.views[1].weight) for v in views] == [
        (0, 0, 1.0),
        (10, 10, 1.0),
        (20, 20, 1.0),
    ]


def test_a_late_camera_is_interpolated_between_the_exposures_around():
    views = list(RecordedPairs(Recording(0, 10, 20, 30), Recording(4, 14, 24)))
    right = [v.views[1] for v in views]
    assert [v.t_ns for v in views] == [0, 10, 20]
    assert [(r.previous and r.previous.capture_ns, r.current.capture_ns) for r in right] == [
        (None, 4),
        (4, 14),
        (14, 24),
    ]
    assert [r.weight for r in right] == [1.0, 0.6, 0.6]


def test_a_third_camera_is_brought_to_the_lefts_instants_and_ends_with_its_recording():
    views = list(RecordedPairs(Recording(0, 10, 20), Recording(0, 10, 20), Recording(5, 15)))
    assert [(v.t_ns, len(v.views)) for v in views] == [(0, 3), (10, 3)]
    assert [(v.views[2].current.capture_ns, v.views[2].weight) for v in views] == [(5, 1.0), (15, 0.5)]


@pytest.mark.parametrize(
    ("counts", "said"),
    [
        ((3, 3), ""),
        ((3, 4), "left ended after 3 pairs while right continued"),
        ((4, 3), "right ended after 3 pairs while left continued"),
        ((1, 2), "left ended after 1 pairs while right continued"),
        ((0, 2), "left ended after 0 pairs while right continued"),
        ((3, 2, 5), "right ended after 2 pairs while left continued"),
        ((2, 2, 5), "left ended after 2 pairs while third continued"),
        ((0, 0), ""),
    ],
)
def test_a_recording_that_goes_on_is_told(counts, said):
    names = ("left", "right", "third")
    pairs = RecordedPairs(
        *(Recording(*range(0, 10 * n, 10), name=name) for n, name in zip(counts, names, strict=False))
    )
    assert len(list(pairs)) == min(counts)
    assert pairs.left_out.partition(";")[0] == said


def test_what_was_left_out_stands_in_the_summary():
    left, right = Recording(0, 10, name="left"), Recording(0, 10, 20, name="right")
    summary = track_recording(exact_rig(StereoConfig()), left, [right], [], lambda _: None)
    assert "warning: left ended after 2 pairs while right continued" in describe(summary, [])


def folder(tmp_path, name, sizes):
    """A folder of dark pictures of these heights and widths."""
    (tmp_path / name).mkdir()
    for k, size in enumerate(sizes):
        cv2.imwrite(str(tmp_path / name / f"{k}.png"), np.full(size, 8 + len(name), np.uint8))
    return str(tmp_path / name)


def video(tmp_path, name, fps, count=3):
    """A video of dark frames."""
    path = str(tmp_path / f"{name}.avi")
    writer = cv2.VideoWriter(path, cv2.VideoWriter.fourcc(*"MJPG"), fps, (64, 48))
    for _ in range(count):
        writer.write(np.full((48, 64, 3), 8 + len(name), np.uint8))
    writer.release()
    return path


def sources(tmp_path, left, right, fps=None):
    save_rig(exact_rig(StereoConfig()), tmp_path / "rig.json")
    return TrackSources(tmp_path / "rig.json", left, right, fps, LocalConfig(tracking=TrackingConfig(method="markers")))


def test_a_recording_that_was_cut_off_is_told_with_the_picture_at_which_it_ends(tmp_path):
    left, right = (Path(video(tmp_path, name, 15, count=60)) for name in ("left", "right"))
    right.write_bytes(right.read_bytes()[: right.stat().st_size * 2 // 3])
    summary = run_track(sources(tmp_path, str(left), str(right)), TrackOutputs(tmp_path / "track.jsonl"))
    assert 0 < summary.pairs < 59
    told = f"warning: camera right: {right} is damaged or was cut off: decoding ended at picture {summary.pairs}"
    assert told in describe(summary, [])


@pytest.mark.parametrize(("left", "right", "refused"), [(15, 30, True), (30, 30.5, True), (30, 29.97, False)])
def test_recordings_of_different_rates_are_refused_unless_the_rate_is_given(tmp_path, left, right, refused):
    given = sources(tmp_path, video(tmp_path, "left", left), video(tmp_path, "right", right))
    out = tmp_path / "track.jsonl"
    if refused:
        with pytest.raises(ConfigError, match=r"left .*right .*--fps"):
            run_track(given, TrackOutputs(out))
        assert not out.exists()
    else:
        assert run_track(given, TrackOutputs(out)).pairs == 3
    assert run_track(dataclasses.replace(given, fps=20.0), TrackOutputs(out)).pairs == 3
    assert [json.loads(line)["t_ns"] for line in out.read_text().splitlines()] == [0, 50_000_000, 100_000_000]


@pytest.mark.parametrize("fps", [1e9, 0.0, -30.0, float("nan"), float("inf")])
def test_a_rate_that_no_camera_has_is_refused_with_the_range(tmp_path, fps):
    given = sources(tmp_path, video(tmp_path, "left", 30), video(tmp_path, "right", 30), fps)
    with pytest.raises(ConfigError, match=r"--fps .*from 0\.1 to 1000"):
        run_track(given, TrackOutputs(tmp_path / "track.jsonl"))


def test_a_picture_of_another_size_is_named_and_what_was_tracked_is_kept(tmp_path):
    left = folder(tmp_path, "left", [(48, 64), (48, 64), (24, 32)])
    right = folder(tmp_path, "right", [(48, 64)] * 3)
    with pytest.raises(CameraError, match="camera left: its picture 2 is 32x24, but its first was 64x48"):
        run_track(sources(tmp_path, left, right), TrackOutputs(tmp_path / "track.jsonl"))
    assert len((tmp_path / "track.jsonl").read_text().splitlines()) == 2


def test_pictures_of_another_size_than_calibrated_are_refused_and_an_earlier_track_is_kept(tmp_path):
    given = sources(tmp_path, folder(tmp_path, "left", [(48, 64)]), folder(tmp_path, "right", [(48, 64)]))
    rig = exact_rig(StereoConfig())
    save_rig(replace(rig, cameras=tuple(replace(c, size_px=(640, 480)) for c in rig.cameras)), given.rig)
    (tmp_path / "track.jsonl").write_text("earlier")
    with pytest.raises(CameraError, match="its picture 0 is 64x48, but it was calibrated at 640x480"):
        run_track(given, TrackOutputs(tmp_path / "track.jsonl"))
    assert (tmp_path / "track.jsonl").read_text() == "earlier"


def test_an_interruption_keeps_the_pairs_tracked_so_far(tmp_path):
    done: list[int] = []
    summary = track_recording(
        exact_rig(StereoConfig()),
        Recording(0, 10, 20),
        [Recording(0, 10, 20)],
        [json_lines(tmp_path / "track.jsonl")],
        done.append,
        should_stop=lambda: len(done) == 2,
    )
    assert summary.pairs == 2
    assert len((tmp_path / "track.jsonl").read_text().splitlines()) == 2


def test_an_interruption_before_the_first_pair_is_no_failure(tmp_path):
    rig, out = exact_rig(StereoConfig()), tmp_path / "track.jsonl"
    summary = track_recording(rig, Recording(0), [Recording(0)], [json_lines(out)], lambda _: None, None, lambda: True)
    assert describe(summary, [out]) == "no pair was tracked"
    assert not out.exists()


def test_what_is_no_file_is_written_through(tmp_path):
    rig, aim = exact_rig(StereoConfig()), tmp_path / "aim.jsonl"
    aim.write_text("earlier")
    (tmp_path / "link.jsonl").symlink_to(aim)
    for out in (tmp_path / "link.jsonl", Path("/dev/null")):
        assert track_recording(rig, Recording(0), [Recording(0)], [json_lines(out)], lambda _: None).pairs == 1
    assert Path("/dev/null").is_char_device()
    assert (tmp_path / "link.jsonl").is_symlink()
    assert '"status":"lost"' in aim.read_text()


def test_dark_recordings_give_lost_lines_and_their_summary(tmp_path):
    annotated = tmp_path / "pictures"
    done: list[int] = []
    summary = track_recording(
        exact_rig(StereoConfig()),
        Recording(0, 10),
        [Recording(0, 10)],
        [json_lines(tmp_path / "track.jsonl"), annotated_pictures(annotated)],
        done.append,
    )
    assert (summary.pairs, summary.statuses[TrackingStatus.LOST], summary.found["wrist"]) == (2, 2, 0)
    assert done == [1, 2]
    assert len((tmp_path / "track.jsonl").read_text().splitlines()) == 2
    assert sorted(p.name for p in annotated.iterdir()) == ["000000.png", "000001.png"]


def test_nothing_to_track_and_nowhere_to_write_are_told(tmp_path):
    rig, absent = exact_rig(StereoConfig()), tmp_path / "absent" / "track.jsonl"
    with pytest.raises(CameraError, match="no pair"):
        track_recording(rig, Recording(), [Recording(0)], [], lambda _: None)
    with pytest.raises(CameraError, match="cannot write"):
        track_recording(rig, Recording(0), [Recording(0)], [json_lines(absent)], lambda _: None)


def test_the_command_tracks_four_cameras(tmp_path):
    for name in ("left", "right", "third", "fourth"):
        (tmp_path / name).mkdir()
        cv2.imwrite(str(tmp_path / name / "0.png"), IMAGE + CAMERAS.index(name))
    pair = exact_rig(StereoConfig())
    four = tuple(replace(pair.cameras[k % 2], name=name) for k, name in enumerate(CAMERAS))
    save_rig(Rig(four, pair.volume_min, pair.volume_max, pair.error_rms, "made up"), tmp_path / "rig.json")
    left, right, *also = (str(tmp_path / name) for name in ("left", "right", "third", "fourth"))
    markers = LocalConfig(tracking=TrackingConfig(method="markers"))
    given = TrackSources(tmp_path / "rig.json", left, right, None, markers, tuple(also))
    summary = run_track(given, TrackOutputs(tmp_path / "track.jsonl", tmp_path / "pictures"))
    assert describe(summary, []).startswith("1 pairs: 1 lost")
    assert present(cv2.imread(str(tmp_path / "pictures" / "000000.png"))).shape == (48 + LINE_HEIGHT_PX, 4 * 64, 3)
