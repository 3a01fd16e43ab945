"""One source for two cameras is refused: by its path, through a link, as a device by two names, and as a copy."""

import shutil
from pathlib import Path

import pytest

from common.errors import ConfigError
from local_site.acquisition import same_source
from local_site.acquisition.same_source import refuse_same


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A file that stands for a video."""
    path = tmp_path / "left.avi"
    path.write_bytes(bytes(range(256)))
    return path


def refuse(left: object, right: object) -> None:
    refuse_same({"left": str(left), "right": str(right)})


def test_different_recordings_cameras_and_streams_are_taken(recording: Path, tmp_path: Path) -> None:
    other = tmp_path / "right.avi"
    other.write_bytes(bytes(reversed(range(256))))
    refuse(recording, other)
    refuse("0", "1")
    refuse("rtsp://one/1", "rtsp://one/2")
    refuse_same({"left": 0, "right": 1, "third": 2})


def test_one_path_is_refused_however_it_is_written(recording: Path, tmp_path: Path) -> None:
    link = tmp_path / "right.avi"
    link.symlink_to(recording)
    for other in (recording, link, tmp_path / "." / ".." / tmp_path.name / "left.avi"):
        with pytest.raises(ConfigError, match=r"cameras left and right: .* are the same; give each camera"):
            refuse(recording, other)


def test_a_copy_is_refused(recording: Path, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="have the same content"):
        refuse(recording, shutil.copy(recording, tmp_path / "right.avi"))


def test_a_folder_and_its_copy_are_refused_and_one_that_differs_is_taken(tmp_path: Path) -> None:
    left = tmp_path / "left"
    left.mkdir()
    for k in range(3):
        (left / f"{k}.png").write_bytes(bytes([k]))
    right = Path(shutil.copytree(left, tmp_path / "right"))
    with pytest.raises(ConfigError, match="have the same content"):
        refuse(left, right)
    (right / "1.png").write_bytes(b"x")
    refuse(left, right)


def test_a_device_by_number_and_by_name_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    device, port = tmp_path / "video4", tmp_path / "by-path"
    device.touch()
    port.symlink_to(device)
    monkeypatch.setattr(same_source, "device_of", lambda source: str(device) if source == "4" else None)
    with pytest.raises(ConfigError, match="are the same"):
        refuse("4", port)


def test_the_third_camera_is_compared_too() -> None:
    with pytest.raises(ConfigError, match="cameras right and third"):
        refuse_same({"left": "0", "right": "1", "third": "/dev/video1"})
