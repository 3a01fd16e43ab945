"""The video of a track: it plays at the recording's rate, and one that cannot be complete never takes its name."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from common.cameras.camera import Image
from common.errors import CameraError, ConfigError
from farhand.tracking.results.video import check_video, overlay_video
from local_site.tracking.annotate import LINE_HEIGHT_PX
from tests.farhand.tracking.results.tracked import HEIGHT, WIDTH, pair, write_then_fail

# A file may not grow beyond what the first pictures take, as on a full disk.
ON_A_FULL_DISK = """
import resource, signal, sys
from pathlib import Path
from farhand.tracking.results.video import overlay_video
from tests.farhand.tracking.results.tracked import pair
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, 2_000))
with overlay_video(Path(sys.argv[1]), 25.0) as take:
    for k in range(20):
        take(pair(k, grey=12 * k))
"""


def pictures(path: Path) -> Iterator[Image]:
    capture = cv2.VideoCapture(str(path))
    while (read := capture.read())[0]:
        yield np.asarray(read[1], dtype=np.uint8)
    capture.release()


@pytest.mark.parametrize("fps", [15.0, 29.97, 30000 / 1001, 240.0])
def test_the_video_has_a_picture_for_each_pair_at_the_recordings_rate(tmp_path: Path, fps: float) -> None:
    check_video("--video", tmp_path / "overlay.mp4", fps)
    with overlay_video(tmp_path / "overlay.mp4", fps) as take:
        for k in range(5):
            take(pair(k, grey=40 * k))
    capture = cv2.VideoCapture(str(tmp_path / "overlay.mp4"))
    assert capture.get(cv2.CAP_PROP_FPS) == pytest.approx(fps, abs=0.01)
    capture.release()
    played = list(pictures(tmp_path / "overlay.mp4"))
    assert [round(float(p[50:70, 300:320].mean()) / 40) for p in played] == [0, 1, 2, 3, 4]
    assert played[0].shape == (HEIGHT + LINE_HEIGHT_PX + 1, 2 * WIDTH, 3), "an odd row is added, not cut"
    assert [path.name for path in tmp_path.iterdir()] == ["overlay.mp4"]


def test_what_was_drawn_before_a_failure_is_kept(tmp_path: Path) -> None:
    with pytest.raises(CameraError, match="unplugged"):
        write_then_fail(overlay_video(tmp_path / "a.mp4", 25.0), 2, CameraError("unplugged"))
    assert len(list(pictures(tmp_path / "a.mp4"))) == 2


def test_an_earlier_video_stays_where_no_picture_came(tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"earlier")
    with overlay_video(tmp_path / "a.mp4", 25.0):
        pass
    assert (tmp_path / "a.mp4").read_bytes() == b"earlier"


def test_a_video_that_found_no_room_is_told_and_the_earlier_one_stays(tmp_path: Path) -> None:
    out = tmp_path / "a.mp4"
    out.write_bytes(b"earlier")
    done = subprocess.run(
        [sys.executable, "-c", ON_A_FULL_DISK, str(out)],
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
        cwd=Path(__file__).parents[4],
    )
    assert "CameraError: cannot write" in done.stderr
    assert "free some space" in done.stderr
    assert out.read_bytes() == b"earlier"
    assert list(tmp_path.iterdir()) == [out]


def test_before_the_disk_is_full_the_video_ends_so_that_it_can_be_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = iter([10**9, 10**9, 10**5])
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=next(free)))
    with pytest.raises(OSError, match="no space is left"):
        write_then_fail(overlay_video(tmp_path / "a.mp4", 25.0), 9, AssertionError("room for all"))
    assert len(list(pictures(tmp_path / "a.mp4"))) == 2


def test_a_rate_that_is_unknown_or_cannot_be_written_is_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="--fps"):
        check_video("--video", tmp_path / "a.mp4", None)
    with pytest.raises(ConfigError, match="pip install opencv-python-headless"):
        check_video("--video", tmp_path / "absent" / "a.mp4", 25.0)
    assert not list(tmp_path.iterdir())


def test_a_picture_too_large_for_the_codec_is_told_at_the_first_pair(tmp_path: Path) -> None:
    large = pair(0)
    large.__dict__["picture"] = np.zeros((200, 8600, 3), np.uint8)
    told = pytest.raises(CameraError, match="8600x200 pixels; leave the video out")
    with told, overlay_video(tmp_path / "a.mp4", 25.0) as take:
        take(large)
    assert not list(tmp_path.iterdir())
