"""H.264 as it is sent: close to its source, in the bytes that it may take, key frames when they are wanted."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from common.cameras.camera import Image
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import ConfigError
from common.messages.video import Codec, VideoFrame
from farhand.loopback.picture_decoder import PictureDecoder
from lab.measure.video.link import live_frame
from lab.stage.clock_strip import draw_clock, read_clock
from remote_site.video.streaming import encoding
from remote_site.video.streaming.codec_choice import CodecPreference
from remote_site.video.streaming.encoding import KEY_FRAMES_APART_NS, PictureEncoder
from remote_site.video.streaming.setting import StreamSetting
from tests.present import present

FULL = StreamSetting(80, 1.0, 30.0, Codec.H264)
PERIOD_NS = 33 * NS_PER_MS


def scene(k: int, width: int = 320, height: int = 240) -> Image:
    """A textured picture (height, width, 3), BGR, that moves by two pixels at each `k`."""
    rng = np.random.default_rng(4)
    still = cv2.GaussianBlur(rng.integers(0, 255, (height, width), dtype=np.uint8), (0, 0), 3.0)
    bright = np.roll(cv2.normalize(still, np.empty_like(still), 0, 255, cv2.NORM_MINMAX), 2 * k, axis=1)
    return np.asarray(np.stack([bright, bright // 2, 255 - bright // 2], axis=2), dtype=np.uint8)


class Stream:
    """An encoder, and the numbers of its pictures."""

    def __init__(self) -> None:
        self.encoder, self.seq = PictureEncoder(), 0

    def next(self, setting: StreamSetting = FULL, image: Image | None = None) -> VideoFrame:
        image = scene(self.seq) if image is None else image
        t_ns = self.seq * PERIOD_NS
        frame = live_frame("side", self.seq, t_ns, self.encoder.encode(image, setting, self.seq, t_ns))
        self.seq += 1
        return frame


def psnr_db(a: Image, b: Image) -> float:
    return float(cv2.PSNR(a, b))


@pytest.mark.parametrize(("picture_bytes", "least_db"), [(None, 33.0), (1500, 28.0)])
def test_a_decoded_picture_is_close_to_its_source_and_keeps_to_its_bytes(
    picture_bytes: int | None, least_db: float
) -> None:
    stream, decoder = Stream(), PictureDecoder()
    setting = replace(FULL, picture_bytes=picture_bytes)
    sent = [stream.next(setting) for _ in range(30)]
    decoded = [decoder.decode(frame) for frame in sent]
    assert [frame.key for frame in sent] == [True] + [False] * 29
    assert psnr_db(present(decoded[-1]), scene(29)) > least_db
    if picture_bytes is not None:
        assert np.mean([len(frame.data) for frame in sent]) < 1.1 * picture_bytes
        assert max(len(frame.data) for frame in sent) < 2.5 * picture_bytes


def test_each_picture_comes_out_as_soon_as_it_goes_in() -> None:
    stream, decoder = Stream(), PictureDecoder()
    for k in range(10):
        picture = scene(0)
        draw_clock(picture, 1_000_000 * NS_PER_MS + k * PERIOD_NS)
        assert read_clock(present(decoder.decode(stream.next(image=picture)))) == 1_000_000 + k * 33


def test_colours_stay_as_they_are_and_odd_sizes_and_grey_pictures_are_taken() -> None:
    image = np.zeros((241, 321, 3), np.uint8)
    image[:] = (200, 30, 10)
    decoded = present(PictureDecoder().decode(Stream().next(image=image)))
    assert decoded.shape == (240, 320, 3)
    assert decoded[24, 32].tolist() == pytest.approx((200, 30, 10), abs=8)
    grey = present(PictureDecoder().decode(Stream().next(image=np.full((240, 320), 90, np.uint8))))
    assert grey[24, 32].tolist() == pytest.approx((90, 90, 90), abs=4)


def test_after_a_lost_picture_none_is_decoded_until_the_key_frame_that_was_asked_for() -> None:
    stream, decoder = Stream(), PictureDecoder()
    assert all(decoder.decode(stream.next()) is not None for _ in range(5))
    stream.next()  # lost
    late = stream.next()
    assert decoder.decode(late) is None
    assert decoder.wants_after == late.seq
    stream.encoder.want_key_frame(decoder.wants_after)
    key = stream.next()
    assert key.key
    assert psnr_db(present(decoder.decode(key)), scene(key.seq)) > 25.0
    assert decoder.decode(stream.next()) is not None


def test_many_requests_for_the_same_gap_give_one_key_frame() -> None:
    stream = Stream()
    sent = []
    for k in range(20):
        for viewer in range(3):
            if k >= 5:
                stream.encoder.want_key_frame(4 - (viewer == 1))
        sent.append(stream.next())
    assert [frame.seq for frame in sent if frame.key] == [0, 5]


def test_a_key_frame_that_was_lost_is_sent_again_and_never_more_than_two_a_second() -> None:
    stream = Stream()
    keys = []
    for k in range(150):
        stream.encoder.want_key_frame(max(0, k - 1))  # somebody who loses every picture
        keys += [frame.capture_ns for frame in [stream.next()] if frame.key]
    assert keys[1] - keys[0] < 2 * KEY_FRAMES_APART_NS
    assert len(keys) >= 9
    assert min(np.diff(keys)) >= KEY_FRAMES_APART_NS
    assert min(later - first for first, later in zip(keys, keys[2:], strict=False)) >= NS_PER_S


@pytest.mark.slow
def test_whoever_asks_for_key_frames_all_the_time_hardly_makes_the_pictures_worse() -> None:
    def quality_db(*, asked: bool) -> float:
        stream, decoder, found = Stream(), PictureDecoder(), []
        for _ in range(90):
            if asked:
                stream.encoder.want_key_frame(2**40)
            frame = stream.next(replace(FULL, picture_bytes=3000))
            found.append(psnr_db(present(decoder.decode(frame)), scene(frame.seq)))
        return float(np.mean(found[30:]))

    assert quality_db(asked=False) - quality_db(asked=True) < 2.0


@pytest.mark.parametrize("change", [{"scale": 0.5}, {"picture_bytes": 2000}])
def test_another_size_or_rate_begins_with_a_key_frame(change: dict[str, Any]) -> None:
    stream, decoder = Stream(), PictureDecoder()
    assert [stream.next().key for _ in range(3)] == [True, False, False]
    changed = replace(FULL, **change)
    frame = stream.next(changed)
    assert frame.key
    assert present(decoder.decode(frame)).shape == (frame.height, frame.width, 3)
    assert not stream.next(changed).key


def test_jpeg_between_is_a_picture_by_itself_and_h264_begins_anew_after_it() -> None:
    stream, decoder = Stream(), PictureDecoder()
    sent = [stream.next(), stream.next(), stream.next(replace(FULL, codec=Codec.JPEG)), stream.next(), stream.next()]
    assert [frame.key for frame in sent] == [True, False, True, True, False]
    assert all(decoder.decode(frame) is not None for frame in sent)


@pytest.mark.parametrize(
    ("wanted", "installed", "encodes"),
    [("auto", True, True), ("auto", False, False), ("jpeg", True, False), ("h264", True, True)],
)
def test_h264_is_sent_where_it_is_wanted_and_installed(
    monkeypatch: pytest.MonkeyPatch, wanted: str, installed: bool, encodes: bool
) -> None:
    monkeypatch.setattr(encoding, "has_h264", lambda: installed)
    assert encoding.can_encode(CodecPreference(wanted)) is encodes


def test_wanting_nothing_but_h264_without_pyav_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(encoding, "has_h264", lambda: False)
    with pytest.raises(ConfigError, match=r"video\.codec = 'h264' needs PyAV.*farhand\[video\]"):
        encoding.can_encode(CodecPreference.H264)
