"""Pairing two recordings by exposure time, and what an empty or unwritable track says."""

import cv2
import numpy as np
import pytest

from common.cameras.camera import Frame
from common.errors import CameraError
from farhand.track import pair_views, track_recording
from farhand.track_command import TrackSources, run_track
from local_site.calibration.rig import Rig, save_rig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.choice import TrackingConfig

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
    views = list(pair_views(Recording(0, 10, 20), Recording(0, 10, 20)))
    assert [(v.t_ns, v.views[1].current.capture_ns, v.views[1].weight) for v in views] == [
        (0, 0, 1.0),
        (10, 10, 1.0),
        (20, 20, 1.0),
    ]


def test_a_late_camera_is_interpolated_between_the_exposures_around():
    views = list(pair_views(Recording(0, 10, 20, 30), Recording(4, 14, 24)))
    right = [v.views[1] for v in views]
    assert [v.t_ns for v in views] == [0, 10, 20]
    assert [(r.previous and r.previous.capture_ns, r.current.capture_ns) for r in right] == [
        (None, 4),
        (4, 14),
        (14, 24),
    ]
    assert [r.weight for r in right] == [1.0, 0.6, 0.6]


def test_a_third_camera_is_brought_to_the_lefts_instants_and_ends_with_its_recording():
    views = list(pair_views(Recording(0, 10, 20), Recording(0, 10, 20), Recording(5, 15)))
    assert [(v.t_ns, len(v.views)) for v in views] == [(0, 3), (10, 3)]
    assert [(v.views[2].current.capture_ns, v.views[2].weight) for v in views] == [(5, 1.0), (15, 0.5)]


def test_dark_recordings_give_lost_lines_and_their_summary(tmp_path):
    annotated = tmp_path / "pictures"
    done = []
    summary = track_recording(
        exact_rig(StereoConfig()), Recording(0, 10), Recording(0, 10), tmp_path / "track.jsonl", annotated, done.append
    )
    assert (summary.pairs, summary.statuses["lost"], summary.found["wrist"]) == (2, 2, 0)
    assert done == [1, 2]
    assert len((tmp_path / "track.jsonl").read_text().splitlines()) == 2
    assert sorted(p.name for p in annotated.iterdir()) == ["000000.png", "000001.png"]


def test_nothing_to_track_and_nowhere_to_write_are_told(tmp_path):
    rig = exact_rig(StereoConfig())
    with pytest.raises(CameraError, match="no pair"):
        track_recording(rig, Recording(), Recording(0), tmp_path / "track.jsonl", None, lambda _: None)
    with pytest.raises(CameraError, match="cannot write"):
        track_recording(rig, Recording(0), Recording(0), tmp_path / "absent" / "track.jsonl", None, lambda _: None)


def test_the_command_tracks_four_cameras(tmp_path):
    for name in ("left", "right", "third", "fourth"):
        (tmp_path / name).mkdir()
        cv2.imwrite(str(tmp_path / name / "0.png"), IMAGE)
    pair = exact_rig(StereoConfig())
    save_rig(Rig(pair.cameras * 2, pair.volume_min, pair.volume_max, pair.error_rms, "made up"), tmp_path / "rig.json")
    left, right, *also = (str(tmp_path / name) for name in ("left", "right", "third", "fourth"))
    markers = TrackingConfig(method="markers")
    sources = TrackSources(tmp_path / "rig.json", left, right, None, markers, tuple(also))
    said = run_track(sources, tmp_path / "track.jsonl", tmp_path / "pictures")
    assert said.startswith("1 pairs: 1 lost")
    assert cv2.imread(str(tmp_path / "pictures" / "000000.png")).shape == (48, 4 * 64, 3)
