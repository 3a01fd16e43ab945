"""Where the link is too narrow for JPEG the pictures become H.264 of full size and rate, and stay young."""

import itertools
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from common.messages.video import Codec
from lab.measure.video.link import Arrival, StreamRun
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.codec_choice import RETRY_NS, CodecPreference
from remote_site.video.streaming.encoding import Encoded
from remote_site.video.streaming.setting import LEAST_BITS, StreamSetting, fit_h264, most_h264_bytes

CONFIG = VideoConfig()
PIXELS = CONFIG.width * CONFIG.height
FULL = StreamSetting(80, 1.0, 30.0)
FULL_H264 = replace(FULL, codec=Codec.H264)
# Textured pictures: 34 Mbit/s as JPEG, 11 as H.264 at its best.
JPEG_BYTES = {"front_high": 33_000, "front_low": 34_000, "side": 38_000, "gripper": 36_000}
H264_BYTES = {"front_high": 9_000, "front_low": 9_000, "side": 10_000, "gripper": 18_000}
STILL_BYTES = 400
HELD_BYTES = 300_000  # in the buffers of a connection
QUALITIES, SIZES = (10, 30, 50, 70, 80, 100), (0.3, 0.4, 0.48, 0.68, 1.0, 5.0)


@dataclass
class Scene:
    """What the cameras see: in a `still` cell H.264 takes next to nothing."""

    still: bool = False


def pictures(scene: Scene) -> Callable[[str, int, StreamSetting], Encoded]:
    """Sizes as x264 makes them: no more than is of use or allowed, the first of each encoder twice that."""
    rng, opened = np.random.default_rng(1), defaultdict[str, tuple[float, int | None]](lambda: (0.0, None))

    def make(camera: str, _seq: int, setting: StreamSetting) -> Encoded:
        width, height = round(CONFIG.width * setting.scale), round(CONFIG.height * setting.scale)
        if setting.codec is Codec.JPEG:
            opened.pop(camera, None)
            size = JPEG_BYTES[camera] * np.interp(setting.quality, QUALITIES, SIZES) * setting.scale**1.9
            return Encoded(Codec.JPEG, True, width, height, bytes(int(size * rng.uniform(0.9, 1.1))))
        is_first, opened[camera] = (
            opened[camera] != (setting.scale, setting.picture_bytes),
            (
                setting.scale,
                setting.picture_bytes,
            ),
        )
        most = setting.picture_bytes or most_h264_bytes(width * height)
        needed = STILL_BYTES if scene.still else H264_BYTES[camera]
        size = min(needed * setting.scale**1.9 * rng.uniform(0.7, 1.3), 1.1 * most)
        return Encoded(Codec.H264, is_first, width, height, bytes(int(2 * most if is_first else size)))

    return make


def through(mbit_s: float, *, h264: bool = True, scene: Scene | None = None) -> StreamRun:
    run = StreamRun(CONFIG, pictures(scene or Scene()), mbit_s, h264=h264)
    run.link.holds_bytes = HELD_BYTES
    return run


def settings(run: StreamRun) -> list[StreamSetting]:
    return [run.adaptation.setting(camera, run.now_ns) for camera in JPEG_BYTES]


def codecs(run: StreamRun) -> set[Codec]:
    return {setting.codec for setting in settings(run)}


def age_ms(arrivals: list[Arrival], percentile: float) -> float:
    return float(np.percentile([arrival.age_ms for arrival in arrivals], percentile))


@pytest.mark.parametrize(("mbit_s", "least_fps"), [(20.0, 28.0), (5.0, 25.0), (2.0, 15.0)])
def test_a_narrow_link_carries_h264_of_full_size_and_rate_and_it_stays_young(mbit_s: float, least_fps: float) -> None:
    run = through(mbit_s)
    run.run(5.0)
    arrivals = run.run(20.0)
    assert codecs(run) == {Codec.H264}
    assert {setting.scale for setting in settings(run)} == {1.0}
    assert len(arrivals) / 20.0 / 4 > least_fps
    assert age_ms(arrivals, 95) < 150.0


def test_a_link_that_carries_jpeg_gets_it_from_the_first_second_on() -> None:
    run = through(100.0)
    run.run(1.0)
    for _ in range(100):
        run.run(0.1)
        assert settings(run) == [FULL] * 4


def test_a_console_without_a_decoder_gets_jpeg_that_fits() -> None:
    run = through(5.0, h264=False)
    run.run(10.0)
    assert codecs(run) == {Codec.JPEG}
    assert age_ms(run.run(10.0), 95) < 300.0


def test_pictures_become_smaller_only_when_h264_of_full_size_does_not_fit() -> None:
    run = through(0.5)
    run.run(25.0)
    arrivals = run.run(20.0)
    assert codecs(run) == {Codec.H264}
    assert max(setting.scale for setting in settings(run)) < 1.0
    assert age_ms(arrivals, 95) < 500.0


@pytest.mark.parametrize(("before", "after"), [(100.0, 5.0), (20.0, 2.0)])
def test_a_link_that_becomes_narrow_is_followed_within_seconds(before: float, after: float) -> None:
    run = through(before)
    run.run(10.0)
    run.link.mbit_s = after
    assert age_ms(run.run(3.0), 100) < 2500.0
    arrivals = run.run(10.0)
    assert age_ms(arrivals, 95) < 300.0
    assert len(arrivals) / 10.0 / 4 > 15.0


def test_a_link_that_becomes_free_carries_jpeg_again_after_a_quiet_minute() -> None:
    run = through(5.0)
    run.run(10.0)
    run.link.mbit_s = 100.0
    run.run(30.0)
    assert codecs(run) == {Codec.H264}
    run.run(45.0)
    assert settings(run) == [FULL] * 4


def test_a_link_is_not_believed_to_carry_what_a_still_scene_has_never_sent() -> None:
    scene = Scene()
    run = through(5.0, scene=scene)
    run.run(10.0)
    scene.still = True
    run.run(40.0)
    scene.still = False
    arrivals = run.run(5.0)
    assert codecs(run) == {Codec.H264}
    assert age_ms(arrivals, 95) < 150.0


def test_every_key_frame_costs_quality_so_the_encoder_is_rarely_opened_anew() -> None:
    run = through(5.0)
    run.run(10.0)
    opened = []
    for _ in range(600):
        run.run(0.1)
        setting = settings(run)[0]
        opened.append((setting.scale, setting.picture_bytes))
    changes = sum(before != after for before, after in itertools.pairwise(opened))
    assert changes < 60


def test_without_pyav_and_by_configuration_it_is_as_it_was_and_always_h264() -> None:
    run = StreamRun(CONFIG, pictures(Scene()), 5.0)
    run.run(5.0)
    assert codecs(run) == {Codec.JPEG}
    always = StreamRun(VideoConfig(codec=CodecPreference.H264), pictures(Scene()), 100.0, h264=True)
    assert codecs(always) == {Codec.H264}
    always.run(5.0)
    assert settings(always) == [FULL_H264] * 4


def test_fewer_bytes_never_give_more_pixels_and_are_kept_to() -> None:
    before, least = (0.0, 0.0), LEAST_BITS * PIXELS * 0.25 / 8
    for rate in np.geomspace(2e3, 2e6, 300):
        setting = fit_h264(rate, PIXELS, FULL_H264, FULL)
        picture_bytes = setting.picture_bytes or most_h264_bytes(round(PIXELS * setting.scale**2))
        assert picture_bytes * setting.fps <= max(1.01 * rate, 1.01 * least * 2.0)
        now = setting.scale, setting.fps
        assert now >= before or now[0] > before[0]
        before = now
    assert setting == FULL_H264


def test_a_small_change_of_rate_keeps_the_encoder() -> None:
    now = fit_h264(100_000.0, PIXELS, FULL_H264, FULL)
    assert fit_h264(93_000.0, PIXELS, FULL_H264, now) == now
    assert fit_h264(125_000.0, PIXELS, FULL_H264, now) == now
    assert fit_h264(85_000.0, PIXELS, FULL_H264, now).picture_bytes == round(85_000 / 30)
    assert fit_h264(140_000.0, PIXELS, FULL_H264, now).picture_bytes == round(140_000 / 30)


def test_the_time_until_jpeg_is_tried_again_is_that_of_the_choice() -> None:
    run = through(5.0)
    run.run(RETRY_NS / 1e9 + 20.0)
    assert codecs(run) == {Codec.H264}


def test_what_is_late_on_a_link_with_room_does_not_make_the_pictures_worse() -> None:
    scene = Scene()
    run = through(5.0, scene=scene)
    run.run(15.0)
    scene.still = True
    run.run(10.0)
    before = settings(run)[0].picture_bytes
    run.viewer.late_ms = 120.0
    run.run(8.0)
    after = settings(run)[0]
    assert before is not None
    assert after.scale == 1.0
    assert after.picture_bytes is None or after.picture_bytes > 0.5 * before
