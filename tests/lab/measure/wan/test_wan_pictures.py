"""What the operator saw, from files of made-up pictures whose figures are known."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from common.cameras.camera import Image
from common.messages.video import Codec, VideoFrame
from lab.measure.video.link import live_frame
from lab.measure.wan.pictures import Likeness, Seen, picture_figures, read_seen, ssim, understated_ms
from lab.stage.stand_ins.pictures import PictureLog, SeenPictures, SightLog, read_pictures, read_sights
from lab.stage.stand_ins.played_remote import FRAME_NS, PlayedCamera, number_of
from remote_site.video.streaming.encoding import Encoded, PictureEncoder
from remote_site.video.streaming.pictures import encode_jpeg
from remote_site.video.streaming.setting import StreamSetting

MS = 1_000_000
SIZE_PX = (64, 48)
CAMERAS = ("left", "right")
COUNT = 5


@pytest.fixture
def source(tmp_path: Path) -> dict[str, Image]:
    rng = np.random.default_rng(2)
    coarse = {name: rng.integers(0, 255, (COUNT, 12, 16, 3), dtype=np.uint8) for name in CAMERAS}
    images = {
        name: np.stack([cv2.resize(image, SIZE_PX, interpolation=cv2.INTER_CUBIC) for image in pictures])
        for name, pictures in coarse.items()
    }
    for name, pictures in images.items():
        np.save(tmp_path / f"{name}.npy", pictures)
    return images


def jpeg(camera: str, seq: int, capture_ns: int, data: bytes) -> VideoFrame:
    return live_frame(camera, seq, capture_ns, Encoded(Codec.JPEG, True, *SIZE_PX, data))


def seen_of(images: dict[str, Image], quality: int, shift: int = 0, late_ms: int = 40) -> list[Seen]:
    """Fifty pictures of each camera, `shift` numbers away from what their exposure says."""
    seen = []
    for camera in CAMERAS:
        for k in range(50):
            capture_ns = k * FRAME_NS
            data = encode_jpeg(images[camera][number_of(capture_ns, COUNT) - shift], quality)
            frame = jpeg(camera, k, capture_ns, data)
            seen.append(Seen(frame, SeenPictures(camera, k, capture_ns + late_ms * MS, late_ms + 1.0)))
    return seen


def test_ssim_is_one_for_the_same_and_falls_with_what_is_lost() -> None:
    rng = np.random.default_rng(1)
    image = np.asarray(cv2.resize(rng.integers(0, 255, (24, 32, 3), dtype=np.uint8), (320, 240)), dtype=np.uint8)
    noisy = [np.clip(image + rng.normal(0, s, image.shape), 0, 255).astype(np.uint8) for s in (5, 20)]
    assert ssim(image, image) == pytest.approx(1.0)
    assert 0.99 > ssim(image, noisy[0]) > ssim(image, noisy[1]) > 0.3


def test_ssim_of_flat_pictures_is_the_published_formula() -> None:
    dark, light = (np.full((40, 40, 3), level, np.uint8) for level in (100, 150))
    c1 = (0.01 * 255) ** 2
    assert ssim(dark, light) == pytest.approx((2 * 100 * 150 + c1) / (100**2 + 150**2 + c1))


def test_what_was_kept_is_read_back_without_a_message_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "pictures"
    log, frames = PictureLog(path), [jpeg("left", k, k * MS, bytes(100 * k)) for k in range(1, 4)]
    for k, frame in enumerate(frames):
        log.add(frame, k)
    log.close()
    assert list(read_pictures(path)) == list(enumerate(frames))
    path.write_bytes(path.read_bytes()[:-1])
    assert list(read_pictures(path)) == list(enumerate(frames))[:2]


def test_sights_are_joined_with_their_pictures(tmp_path: Path) -> None:
    pictures, sights = tmp_path / "pictures", tmp_path / "seen"
    kept, seen = PictureLog(pictures), SightLog(sights)
    for k in range(4):
        kept.add(jpeg("left", k, k * MS, b"picture"), k)
    for sight in (
        (one := SeenPictures("left", 1, 50 * MS, 48.5)),
        SeenPictures("left", 9, 1, None),
        (other := SeenPictures("left", 3, 2, None)),
    ):
        seen.add(sight)
    kept.close()
    seen.close()
    with sights.open("a") as file:
        file.write("left,2,12")  # the page was ended meanwhile
    assert read_sights(sights)[0] == one
    joined = read_seen(pictures, sights)
    assert [(each.frame.seq, each.sight) for each in joined] == [(1, one), (3, other)]
    assert joined[0].age_ms == pytest.approx(49.0)


def test_rate_age_and_size_are_those_of_the_time_looked_at(source: dict[str, Image]) -> None:
    seen = [one for one in seen_of(source, 80) if one.frame.camera == "left" or one.frame.seq % 2]
    begin, end = 10 * FRAME_NS + 40 * MS, 40 * FRAME_NS + 40 * MS
    figures = picture_figures(seen, CAMERAS, begin, end)
    assert figures["fps"] == pytest.approx(15.0, rel=0.01)  # of the camera that came less often
    assert (figures["age_p50_ms"], figures["age_p95_ms"]) == (pytest.approx(40.0), pytest.approx(40.0))
    assert figures["width_px"] == SIZE_PX[0]
    missing = picture_figures(seen, (*CAMERAS, "third"), begin, end)
    assert missing["fps"] == 0.0


def test_an_age_that_the_page_had_to_believe_too_small_is_seen(source: dict[str, Image]) -> None:
    seen = seen_of(source, 80)
    assert understated_ms(seen) == pytest.approx(-1.0)
    late = Seen(seen[0].frame, SeenPictures("left", 0, seen[0].sight.seen_ns + 60 * MS, 41.0))
    assert understated_ms([*seen, late]) == pytest.approx(59.0)
    assert understated_ms([]) is None


def test_likeness_compares_each_picture_with_the_one_that_was_played(source: dict[str, Image], tmp_path: Path) -> None:
    likeness, end = Likeness(tmp_path), 50 * FRAME_NS
    full, poor, shifted = (
        likeness.figures(seen_of(source, *how), CAMERAS, 0, end) for how in ((80, 0), (10, 0), (80, 1))
    )
    assert full["ssim"] > 0.9
    assert full["ssim_below_jpeg"] == pytest.approx(0.0, abs=1e-9)
    assert poor["ssim_below_jpeg"] > 0.05
    assert shifted["ssim"] < 0.6
    assert likeness.figures([], CAMERAS, 0, end) == {"ssim": None, "ssim_below_jpeg": None}


def test_h264_is_decoded_from_its_key_frame_and_not_beyond_a_gap(source: dict[str, Image], tmp_path: Path) -> None:
    pytest.importorskip("av")
    encoder, setting, seen = PictureEncoder(), StreamSetting(80, 1.0, 30.0, Codec.H264, 20_000), []
    for k in range(40):
        encoded = encoder.encode(source["left"][k % COUNT], setting, k, k * FRAME_NS)
        frame = live_frame("left", k, k * FRAME_NS, encoded)
        seen.append(Seen(frame, SeenPictures("left", k, k * FRAME_NS, None)))
    likeness, begin, end = Likeness(tmp_path), 20 * FRAME_NS, 40 * FRAME_NS
    assert likeness.figures(seen, ("left",), begin, end)["ssim"] > 0.9
    assert likeness.figures(seen[:10] + seen[11:], ("left",), begin, end)["ssim"] is None
    assert picture_figures(seen, ("left",), begin, end)["h264"] == 1.0


def test_a_played_camera_shows_the_picture_of_its_exposure(
    source: dict[str, Image], monkeypatch: pytest.MonkeyPatch
) -> None:
    phase_ns = FRAME_NS // 4
    camera = PlayedCamera("left", source["left"], phase_ns)
    for now_ns in (7 * FRAME_NS + phase_ns, 8 * FRAME_NS + phase_ns - 1, 8 * FRAME_NS + phase_ns):
        monkeypatch.setattr("lab.stage.stand_ins.played_remote.time.monotonic_ns", lambda now_ns=now_ns: now_ns)
        frame = camera.newest()
        assert 0 <= now_ns - frame.capture_ns < FRAME_NS
        assert frame.seq == (7 if now_ns < 8 * FRAME_NS + phase_ns else 8)
        assert np.array_equal(frame.image, source["left"][number_of(frame.capture_ns, COUNT)])
