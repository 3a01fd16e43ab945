"""Camera sources that a test can make: files, folders, and everything that is none."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from common.cameras.images import write_image
from common.cameras.settings import CameraSettings
from common.cameras.sources import damage_of, open_camera, stated_frames
from common.errors import CameraError, ConfigError
from tests.present import present


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for k in range(3):
        cv2.imwrite(str(tmp_path / f"{k:03d}.png"), np.full((48, 64), 60 * k, dtype=np.uint8))
    return tmp_path


def test_a_folder_is_read_in_order_and_ends(folder: Path) -> None:
    camera = open_camera(str(folder), "left", fps=10)
    frames = [camera.read() for _ in range(4)]
    assert [f.capture_ns for f in frames if f] == [0, 100_000_000, 200_000_000]
    assert [int(f.image[0, 0, 0]) for f in frames if f] == [0, 60, 120]
    assert frames[3] is None
    camera.close()


def test_a_broken_image_is_named(folder: Path) -> None:
    (folder / "001.png").write_bytes(b"no image")
    camera = open_camera(str(folder), "left")
    camera.read()
    with pytest.raises(CameraError, match=r"001\.png"):
        camera.read()


def test_a_video_file_is_stamped_by_its_rate(tmp_path: Path) -> None:
    path = tmp_path / "a.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 48))
    for _ in range(3):
        writer.write(np.zeros((48, 64, 3), dtype=np.uint8))
    writer.release()
    camera = open_camera(str(path), "left")
    frames = [camera.read() for _ in range(4)]
    assert [f.capture_ns for f in frames if f] == [0, 50_000_000, 100_000_000]
    assert frames[3] is None
    camera.close()
    slow = open_camera(str(path), "left", fps=5)
    assert [present(slow.read()).capture_ns for _ in range(2)] == [0, 200_000_000]


def test_a_video_that_was_cut_off_says_where(tmp_path: Path) -> None:
    path = tmp_path / "a.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 48))
    noise = np.random.default_rng(1)
    for _ in range(30):
        writer.write(noise.integers(0, 255, (48, 64, 3)).astype(np.uint8))
    writer.release()

    def read_all() -> tuple[int, str]:
        camera = open_camera(str(path), "left")
        assert damage_of(camera) == ""
        count = sum(1 for _ in iter(camera.read, None))
        return count, damage_of(camera)

    assert read_all() == (30, "")
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    count, damage = read_all()
    assert 10 < count < 20
    assert damage == (
        f"camera left: {path} is damaged or was cut off: decoding ended at picture {count}, but it states 30; "
        "copy it again or record anew"
    )


@pytest.mark.parametrize("source", ["/dev/video97", 97, "absent.avi", "empty", "notes.txt"])
def test_what_is_no_camera_is_refused_by_name(source: str | int, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "notes.txt").write_text("no video")
    place = source if isinstance(source, int) or source.startswith("/") else str(tmp_path / source)
    with pytest.raises(CameraError, match="camera left"):
        open_camera(place, "left")


def test_settings_override_the_rate_of_a_recording(folder: Path) -> None:
    camera = open_camera(str(folder), "left", fps=10, settings=CameraSettings(fps=20.0, gain=3))
    assert [frame.capture_ns for frame in (camera.read(), camera.read()) if frame] == [0, 50_000_000]


def test_a_rate_that_is_none_is_refused(folder: Path) -> None:
    with pytest.raises(ConfigError, match="positive"):
        open_camera(str(folder), "left", fps=0)


def test_a_recording_states_its_frames_and_a_nonsense_count_is_none(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (folder / "notes.txt").touch()
    assert stated_frames(open_camera(str(folder), "left")) == 3
    path = tmp_path / "a.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 48))
    for _ in range(5):
        writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    assert stated_frames(open_camera(str(path), "left")) == 5
    for stated in (0.0, -9.2e18, 9.2e18, float("nan")):
        monkeypatch.setattr("cv2.VideoCapture", lambda _, stated=stated: Stating(stated))
        assert stated_frames(open_camera(str(path), "left")) is None
        assert stated_frames(open_camera("0", "left")) is None


class Stating:
    """A capture of a file or a camera that states this number of frames."""

    def __init__(self, frames: float) -> None:
        self._frames = frames

    def isOpened(self) -> bool:
        return True

    def get(self, key: int) -> float:
        return self._frames if key == cv2.CAP_PROP_FRAME_COUNT else 20.0

    def getBackendName(self) -> str:
        return "a backend"

    def read(self) -> tuple[bool, np.ndarray]:
        return True, np.zeros((48, 64, 3), np.uint8)

    def set(self, _key: int, _value: float) -> bool:
        return True


def test_a_pictures_name_stays_in_its_folder(tmp_path: Path) -> None:
    for name in ("../../outside", "/outside", "front\nside"):
        write_image(tmp_path / "views", name, np.zeros((8, 8, 3), np.uint8))
    assert sorted(path.name for path in tmp_path.rglob("*.png")) == [
        "_._.._outside.png",
        "_outside.png",
        "front_side.png",
    ]


def test_a_picture_that_cannot_be_written_is_named_as_its_file(tmp_path: Path) -> None:
    (tmp_path / "views").write_text("not a folder")
    with pytest.raises(CameraError, match=r"cannot write \S+/views/front_side\.png: "):
        write_image(tmp_path / "views", "front/side", np.zeros((8, 8, 3), np.uint8))
