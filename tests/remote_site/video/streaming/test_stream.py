"""A camera's stream numbers its pictures and never shows an old one as live."""

import numpy as np
import pytest
import simplejpeg
from hypothesis import given
from hypothesis import strategies as st

from common.cameras.camera import Frame, Image
from common.messages.codec import encode
from common.messages.video import CameraStatus
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg
from remote_site.video.streaming.setting import StreamSetting
from remote_site.video.streaming.stream import CameraStream
from tests.present import present

MS = 1_000_000
CONFIG = VideoConfig(frozen_ms=500.0, status_hz=5.0)
FULL = StreamSetting(80, 1.0, 30.0)


def picture(seed: int) -> Image:
    return np.random.default_rng(seed).integers(0, 255, (48, 64, 3), dtype=np.uint8)


def frame(k: int, image: Image | None = None, estimated: bool = False) -> Frame:
    return Frame(picture(k) if image is None else image, 1 + k * 33 * MS, k, estimated)


def real() -> CameraStream:
    return CameraStream("side", CONFIG, noise_free=False)


def simulated() -> CameraStream:
    return CameraStream("side", CONFIG, noise_free=True)


def test_new_pictures_are_live_numbered_and_stamped_with_their_exposure():
    stream = real()
    messages = [stream.take(frame(k, estimated=True), FULL, k * 33 * MS) for k in range(5)]
    assert [present(m).seq for m in messages] == [0, 1, 2, 3, 4]
    assert [present(m).capture_ns for m in messages] == [frame(k).capture_ns for k in range(5)]
    assert all(present(m).status is CameraStatus.LIVE and present(m).capture_estimated for m in messages)
    assert (present(messages[0]).width, present(messages[0]).height) == (64, 48)
    assert simplejpeg.decode_jpeg(present(messages[0]).data).shape == (48, 64, 3)


def test_the_same_frame_is_published_once():
    stream = real()
    assert stream.take(frame(1), FULL, 0) is not None
    assert stream.take(frame(1), FULL, 10 * MS) is None


def test_an_older_frame_is_never_published_after_a_newer_one():
    stream = real()
    stream.take(frame(5), FULL, 0)
    assert stream.take(frame(4), FULL, 10 * MS) is None


def test_no_new_exposure_for_half_a_second_is_frozen():
    stream = real()
    stream.take(frame(1), FULL, 0)
    assert stream.take(frame(1), FULL, 500 * MS) is None
    told = present(stream.take(frame(1), FULL, 501 * MS))
    assert told.status is CameraStatus.FROZEN
    assert told.data == b""
    assert "side" in told.reason
    assert "no new picture" in told.reason


def test_identical_pictures_of_a_real_camera_are_frozen_though_freshly_stamped():
    stream = real()
    statuses = {k: stream.take(frame(k, picture(0)), FULL, k * 33 * MS) for k in range(30)}
    assert present(statuses[15]).status is CameraStatus.LIVE
    frozen = [m for m in statuses.values() if m is not None and m.status is CameraStatus.FROZEN]
    assert frozen
    assert all(m.data == b"" and "same picture" in m.reason for m in frozen)
    assert all(statuses[k] is None or present(statuses[k]).status is CameraStatus.FROZEN for k in range(17, 30))


def test_a_simulated_view_at_rest_is_live():
    stream = simulated()
    messages = [stream.take(frame(k, picture(0)), FULL, k * 33 * MS) for k in range(60)]
    assert all(present(m).status is CameraStatus.LIVE for m in messages)


def test_a_camera_that_comes_back_is_live_at_once():
    stream = real()
    stream.take(frame(0), FULL, 0)
    assert present(stream.take(frame(0), FULL, 800 * MS)).status is CameraStatus.FROZEN
    assert present(stream.take(frame(40), FULL, 850 * MS)).status is CameraStatus.LIVE


def test_a_camera_that_never_gave_a_picture_is_missing():
    stream = real()
    assert stream.take(None, FULL, 0) is None
    told = present(stream.take(None, FULL, 600 * MS))
    assert told.status is CameraStatus.MISSING
    assert "no picture yet" in told.reason
    assert told.capture_ns == 0


def test_missing_is_told_with_its_reason_five_times_a_second():
    stream = real()
    told = [stream.missing("camera side: unplugged", k * 33 * MS) for k in range(31)]
    spoken = [m for m in told if m is not None]
    assert len(spoken) == 5
    assert spoken[0].reason == "camera side: unplugged"
    assert spoken[0].status is CameraStatus.MISSING


@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 400)), max_size=40))
def test_only_what_is_new_is_ever_live(steps):
    stream, now_ns, k, last = real(), 0, 0, -1
    for ahead, pause_ms in steps:
        now_ns, k = now_ns + pause_ms * MS, k + ahead
        message = stream.take(frame(k), FULL, now_ns)
        if message is not None and message.status is CameraStatus.LIVE:
            assert message.capture_ns > last
            last = message.capture_ns
        elif message is not None:
            assert message.data == b""


def test_a_very_long_reason_still_fits_the_wire():
    message = present(real().missing("x" * 1000, 0))
    assert encode(message)


def test_grey_and_colour_are_encoded():
    for image in (picture(0), picture(0)[:, :, 0], np.asfortranarray(picture(0))):
        assert simplejpeg.decode_jpeg_header(encode_jpeg(image, 80))[:2] == (48, 64)


def test_blue_stays_blue():
    image = np.zeros((16, 16, 3), np.uint8)
    image[:] = (200, 30, 10)
    red, _, blue = simplejpeg.decode_jpeg(encode_jpeg(image, 95))[8, 8]
    assert blue == pytest.approx(200, abs=8)
    assert red == pytest.approx(10, abs=8)
