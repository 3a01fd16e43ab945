"""Cameras found, tried and chosen; their sizes and rates, offered and verified."""

import numpy as np
import pytest

from common.cameras.images import ImageFolder, write_image
from common.cameras.live import LiveCamera
from common.cameras.modes import CameraMode
from common.cameras.settings import AS_IT_IS, CameraSettings
from common.clock import FakeClock
from common.errors import CameraError
from farhand.setup.camera_modes import choose_settings, common_sizes, needed_format, verify
from farhand.setup.finding_cameras import choose_cameras, find_devices, thumbnail, try_cameras
from tests.common.cameras.fake_capture import FakeCapture
from tests.farhand.setup.board_cameras import BoardCamera
from tests.farhand.setup.scripted_person import ScriptedPerson

BOTH = {"left": "/dev/video0", "right": "/dev/video2"}
MODES = (
    CameraMode("YUYV", 640, 480, (30.0, 15.0)),
    CameraMode("YUYV", 1280, 720, (10.0,)),
    CameraMode("MJPG", 1280, 720, (60.0, 30.0)),
    CameraMode("YUYV", 160, 120, (30.0,)),
)


def live(source, name, settings):
    capture = FakeCapture(FakeClock())
    return LiveCamera(source, name, settings, open_source=lambda _: capture, clock=capture.clock)


def test_devices_are_named_by_their_port_where_they_have_one(tmp_path):
    devices, paths = tmp_path / "dev", tmp_path / "by-path"
    devices.mkdir()
    paths.mkdir()
    for number in (10, 2, 0):
        (devices / f"video{number}").touch()
    (devices / "video-codec").touch()
    (paths / "usb-1-index0").symlink_to(devices / "video2")
    found = find_devices(devices, paths)
    assert found == [str(devices / "video0"), str(paths / "usb-1-index0"), str(devices / "video10")]
    assert find_devices(devices, tmp_path / "absent")[1] == str(devices / "video2")


@pytest.mark.slow
def test_a_camera_that_fails_is_told_with_its_cure_and_the_others_are_tried():
    person = ScriptedPerson()
    found = try_cameras(["fake://broken", "fake://a", "fake://b"], BoardCamera, person)
    assert list(found) == ["fake://a", "fake://b"]
    assert person.told == ["camera broken: cannot open fake://broken; is it plugged in, and may this user read it?"]


def test_a_source_without_a_picture_is_told():
    class Silent(BoardCamera):
        def read(self):
            return None

    person = ScriptedPerson()
    assert not try_cameras(["fake://a"], Silent, person)
    assert person.heard("gives no picture; many cameras have a second device that never gives one")


def test_left_is_chosen_by_thumbnails_and_the_other_of_two_is_right(tmp_path):
    grey = {name: np.full((480, 640, 3), level, np.uint8) for name, level in (("x", 40), ("y", 90))}
    person = ScriptedPerson({"left": "2"})
    assert choose_cameras(grey, tmp_path, person) == ("y", "x")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["camera_1.png", "camera_2.png"]
    assert person.heard("2: y, 640 x 480 px, mean brightness 90 of 255")


def test_of_three_cameras_both_are_chosen_and_none_twice(tmp_path):
    grey = {name: np.zeros((48, 64), np.uint8) for name in "xyz"}
    person = ScriptedPerson({"left": ["7", "3"], "right": ["3", "2"]})
    assert choose_cameras(grey, tmp_path, person) == ("z", "y")
    assert person.heard("answer one of 1, 2, 3")
    assert person.heard("answer one of 1, 2")


def test_a_single_camera_is_refused_with_what_to_do(tmp_path):
    with pytest.raises(CameraError, match=r"1 of the two cameras.*USB port.*farhand setup --camera"):
        choose_cameras({"x": np.zeros((48, 64), np.uint8)}, tmp_path, ScriptedPerson())


def test_a_thumbnail_is_small_and_shows_its_number():
    one, two = (thumbnail(np.full((960, 1280), 128, np.uint8), number) for number in "12")
    assert one.shape == (360, 480)
    assert not np.array_equal(one, two)


def test_sizes_that_both_offer_and_formats_that_are_quick_enough_are_chosen():
    small = MODES[:1]
    assert common_sizes([MODES, MODES]) == [(640, 480), (1280, 720)]
    assert common_sizes([MODES, small]) == [(640, 480)]
    assert common_sizes([MODES, ()]) == []
    assert needed_format([MODES, MODES], (640, 480), 30.0) == "YUYV"
    assert needed_format([MODES, MODES], (1280, 720), 30.0) == "MJPG"
    assert needed_format([MODES, MODES], (1280, 720), 120.0) is None
    assert needed_format([MODES, ()], (640, 480), 30.0) is None


def test_what_a_camera_does_not_give_is_told_and_asked_again():
    person = ScriptedPerson({"size": ["wide", "1000x700", "1280x720"], "pictures a second": ["500", "30", "30"]})
    settings = choose_settings(BOTH, lambda _: MODES, live, person)
    assert settings == CameraSettings(width_px=1280, height_px=720, fps=30.0, pixel_format="MJPG")
    assert person.heard("the size must be two whole numbers")
    assert person.heard("answer a number from 5 to 240")
    assert person.heard("choose another size or rate")
    assert person.heard("both cameras offer 640x480, 1280x720")


def test_a_camera_that_focuses_by_itself_is_warned_of():
    said = verify(BOTH, CameraSettings(width_px=640, height_px=480), live)
    assert said[0].startswith("left: 640 x 480")
    assert any("right focuses by itself" in sentence for sentence in said)


def test_a_recording_that_ends_has_nothing_to_verify(tmp_path):
    write_image(tmp_path, "0", np.zeros((48, 64), np.uint8))
    assert verify(BOTH, AS_IT_IS, lambda _source, name, _settings: ImageFolder(tmp_path, name, 30.0)) == []
