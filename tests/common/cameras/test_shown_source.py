"""No password of a camera's URL is shown: not in errors, findings, reports, or what viewers see."""

import subprocess
import sys

import cv2
import numpy as np
import pytest

from common.cameras.live import LiveCamera
from common.cameras.settings import CameraSettings
from common.cameras.shown_source import shown_source
from common.cameras.sources import open_camera
from common.clock import FakeClock
from common.errors import CameraError, ConfigError
from farhand.calibration.pictures import by_name, read_pictures
from farhand.doctor.cameras import CameraFacts, check_camera, probe_camera
from farhand.setup.finding_cameras import try_cameras
from lab.stage.waiting import until
from remote_site.video.config import CameraConfig
from remote_site.video.sources import ThreadedCamera
from tests.common.cameras.fake_capture import FakeCapture
from tests.farhand.setup.scripted_person import ScriptedPerson

NOBODY = "http://anna:s3cret@127.0.0.1:1/s3cret?password=s3cret"  # nobody listens there


@pytest.mark.parametrize(
    ("source", "shown"),
    [
        (0, "0"),
        ("/dev/video4", "/dev/video4"),
        ("films/take@2.mp4", "films/take@2.mp4"),
        ("rtsp://192.0.2.7:554/stream1", "rtsp://192.0.2.7:554"),
        ("rtsp://anna:s3cret@192.0.2.7:554/stream1", "rtsp://192.0.2.7:554"),
        ("rtsp://anna:s3cret@[2001:db8::7]/x", "rtsp://[2001:db8::7]"),
        ("http://camera.example.org/mjpg?user=anna&password=s3cret", "http://camera.example.org"),
        ("rtsp://192.0.2.7/user=anna_password=s3cret_channel=1.sdp", "rtsp://192.0.2.7"),
        ("rtsp://anna:s3cret/1@192.0.2.7/x", "rtsp://..."),
        ("rtsp://anna:it@s3cret@192.0.2.7/x", "rtsp://..."),
        ("http://192.0.2.7/x?mail=a@s3cret", "http://..."),
        ("rtsp://anna:s3cret@", "rtsp://..."),
        ("rtsp:/anna:s3cret@192.0.2.7/x", "..."),
    ],
)
def test_what_is_shown_of_a_source(source, shown):
    assert shown_source(source) == shown


class _Ending(FakeCapture):
    def read(self):
        return False, None


class _Closed(FakeCapture):
    def isOpened(self):
        return False


def _live(capture, settings):
    return LiveCamera(NOBODY, "left", settings, open_source=lambda _: capture, clock=FakeClock(1))


def _said_by_a_camera_of_the_cell():
    camera = ThreadedCamera("front", lambda: open_camera(CameraConfig(name="front", source=NOBODY).source, "front"))
    try:
        until(lambda: camera._failure)
        camera.newest()
    finally:
        camera.close()


@pytest.mark.parametrize(
    "told",
    [
        lambda: _live(_Closed(FakeClock(1)), CameraSettings()),
        lambda: _live(_Ending(FakeClock(1)), CameraSettings()),
        lambda: _live(FakeCapture(FakeClock(1)), CameraSettings(focus=12)),
        _said_by_a_camera_of_the_cell,
        lambda: open_camera(NOBODY.replace("//", "/"), "left"),
        lambda: read_pictures(NOBODY, "left"),
        lambda: by_name((NOBODY, NOBODY)),
    ],
)
def test_errors_show_no_password(told):
    with pytest.raises((CameraError, ConfigError)) as caught:
        told()
    assert "s3cret" not in str(caught.value)
    assert "s3cret" not in repr(caught.value.__context__)


def test_the_doctor_and_the_setup_show_no_password():
    found = [probe_camera("left", NOBODY, 30.0), CameraFacts("left", shown_source(NOBODY), (640, 480))]
    assert not any("s3cret" in str(check_camera(facts)) for facts in found)
    person = ScriptedPerson({})
    assert try_cameras([NOBODY], lambda source, name, _: open_camera(source, name), person) == {}
    assert "s3cret" not in str(vars(person))


@pytest.mark.parametrize(
    "source",
    [
        "rtsp://anna:s3cret%2F@127.0.0.1:1/x",
        "http://anna:s3cret%40@127.0.0.1:1/x.jpg",
        "http://anna:s3cret@127.0.0.1:1/x_0001.jpg",
        "http:/anna:s3cret%2F@127.0.0.1:1/x",
        "77",
    ],
)
def test_no_library_prints_a_source_that_cannot_be_opened(source):
    """With a percent sign it is a pattern of numbered pictures to OpenCV, which printed it to the log, and again."""
    script = "import sys; from common.cameras.sources import open_camera; open_camera(sys.argv[1], 'left')"
    ended = subprocess.run([sys.executable, "-c", script, source], capture_output=True, text=True, check=False)
    assert "s3cret" not in ended.stdout + ended.stderr.replace(repr(source), "")
    assert "WARN" not in ended.stderr
    assert ended.stderr.splitlines()[-1].startswith("common.errors.CameraError: camera left: ")


def test_a_stream_is_read_through_ffmpeg(tmp_path):
    film = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"MJPG"), 30.0, (64, 48))
    for _ in range(40):
        writer.write(np.full((48, 64, 3), 99, np.uint8))
    writer.release()
    camera = LiveCamera(f"file://{film}", "left", CameraSettings())
    frame = camera.read()
    assert frame is not None
    assert abs(int(frame.image[10, 10, 0]) - 99) < 4
    camera.close()
