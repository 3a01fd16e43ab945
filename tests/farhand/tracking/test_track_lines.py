"""What a track contains beside its points: how certain they are, and that a camera has moved since calibration."""

import json

import numpy as np
import pytest

import farhand.tracking.track
from common.cameras.camera import Frame
from common.clock import NS_PER_S
from common.messages.hand import TrackingStatus
from farhand.tracking.results.outputs import json_lines
from farhand.tracking.summary import describe
from farhand.tracking.track import track_recording
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.tracker import ArmEstimate

IMAGE = np.full((48, 64), 8, np.uint8)
WRIST = np.array([0.4, 0.3, 0.5])


class Recording:
    """Frames 33 ms apart."""

    name = "camera"

    def __init__(self, count):
        self._frames = iter([Frame(IMAGE, 33_000_000 * k, k) for k in range(count)])

    def read(self):
        return next(self._frames, None)

    def close(self):
        pass


class Scripted:
    """A tracker that answers as a test wants it to: an estimate from the time."""

    def __init__(self, answer):
        self._answer = answer

    def track(self, views):
        return self._answer(views.t_ns)


@pytest.fixture
def track(monkeypatch, tmp_path):
    """Runs this many pairs through a scripted tracker; gives the summary and the lines."""

    def run(answer, count):
        monkeypatch.setattr(farhand.tracking.track, "make_tracker", lambda *_: Scripted(answer))
        path = tmp_path / "track.jsonl"
        rig = exact_rig(StereoConfig())
        summary = track_recording(rig, Recording(count), [Recording(count)], [json_lines(path)], lambda _: None)
        return summary, [json.loads(line) for line in path.read_text().splitlines()]

    return run


def test_sigma_is_the_rms_length_of_the_points_error(track):
    random = np.random.default_rng(0)
    factor = random.normal(0.0, 0.003, (3, 3))

    def answer(t_ns):
        return ArmEstimate(t_ns, TrackingStatus.TRACKED, "", wrist=WRIST, covariances={"wrist": factor @ factor.T})

    _, (line,) = track(answer, 1)
    errors = np.linalg.norm(random.standard_normal((100_000, 3)) @ factor.T, axis=1)
    assert line["sigma"]["wrist"] == pytest.approx(np.sqrt(np.mean(errors**2)), rel=0.01)


def test_sigma_is_null_where_there_is_no_point_or_no_covariance(track):
    def answer(t_ns):
        covariances = {"elbow": np.eye(3), "thumb": np.full((3, 3), np.nan)}
        return ArmEstimate(t_ns, TrackingStatus.TRACKED, "", wrist=WRIST, thumb=WRIST, covariances=covariances)

    _, (line,) = track(answer, 1)
    assert line["sigma"] == {"elbow": None, "wrist": None, "index": None, "thumb": None}


def wobbling(bump_s):
    """Residuals of 0.5 px, and of 4 px once a camera was bumped."""

    def answer(t_ns):
        residual_px = (0.5 if t_ns < bump_s * NS_PER_S else 4.0) * (1 + 0.1 * np.sin(t_ns))
        return ArmEstimate(t_ns, TrackingStatus.DEGRADED, "folded", residual_px=residual_px)

    return answer


def test_a_camera_that_moves_is_told_in_the_reasons_and_the_summary(track):
    summary, lines = track(wobbling(bump_s=15), 30 * 30)
    told = [k for k, line in enumerate(lines) if "calibrate again" in line["reason"]]
    assert told == list(range(told[0], len(lines)))
    assert 15 < lines[told[0]]["t_ns"] / NS_PER_S < 26
    assert lines[-1]["reason"].startswith("folded; tracked points miss")
    assert f"\nwarning: {summary.drift}" in describe(summary, [])


def test_cameras_that_stand_give_no_warning(track):
    summary, lines = track(wobbling(bump_s=60), 30 * 30)
    assert {line["reason"] for line in lines} == {"folded"}
    assert summary.drift is None
    assert "warning" not in describe(summary, [])


def test_a_short_track_with_another_rigs_file_ends_with_the_cure(track):
    def answer(t_ns):
        covariances = {"wrist": 1e-5 * np.eye(3)}
        return ArmEstimate(t_ns, TrackingStatus.TRACKED, "", wrist=WRIST, covariances=covariances, residual_px=9.0)

    summary, _ = track(answer, 30)
    assert describe(summary, []).endswith(
        "the calibration does not fit these cameras; calibrate again, or give the file of this rig"
    )
    assert "9.0 px" in summary.misfit
