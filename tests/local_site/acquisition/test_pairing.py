"""Frames of several cameras brought to common instants."""

import cv2
import numpy as np
import pytest

from common.cameras.camera import Frame
from common.clock import NS_PER_MS
from local_site.acquisition.pairing import Pairing, PairingConfig

PERIOD_MS = 33.0


def picture(k):
    image = np.zeros((4, 6), np.uint8)
    image.flat[:2] = divmod(k, 256)
    return image


def frame(t_ms, k=None, image=None):
    k = round(t_ms * 10) if k is None else k
    return Frame(picture(k) if image is None else image, round(t_ms * NS_PER_MS), k)


def pairing(names=("left", "right"), start_ms=0.0, **settings):
    return Pairing(names, PairingConfig(**settings), round(start_ms * NS_PER_MS))


def feed_all(pair, events):
    """Feed (t_ms, camera) in order and collect the views."""
    fed = [pair.feed(camera, frame(t_ms)) for t_ms, camera in events]
    return [views for views in fed if views is not None]


def events(offset_ms, count=6, jitter=None, period_ms=PERIOD_MS):
    shakes = np.zeros((count, 2)) if jitter is None else jitter
    left = [(100 + k * period_ms + shakes[k, 0], 0) for k in range(count)]
    right = [(100 + k * period_ms + offset_ms + shakes[k, 1], 1) for k in range(count)]
    return sorted(left + right)


def test_frames_within_the_tolerance_are_a_pair_as_they_are():
    found = feed_all(pairing(), events(offset_ms=1.0))
    assert len(found) == 6
    for k, views in enumerate(found):
        assert views.t_ns == round((100.5 + k * PERIOD_MS) * NS_PER_MS)
        assert [view.weight for view in views.views] == [1.0, 1.0]
        assert [view.previous for view in views.views] == [None, None]


def test_a_synchronous_pair_needs_no_second_pair():
    pair = pairing()
    assert pair.feed(0, frame(100.0)) is None
    assert pair.feed(1, frame(100.0)).t_ns == 100 * NS_PER_MS


@pytest.mark.parametrize(("offset_ms", "count"), [(5.0, 6), (11.0, 10), (16.5, 10), (28.0, 6)])
def test_unsynchronised_frames_are_interpolated_within_their_exposures(offset_ms, count):
    found = feed_all(pairing(), events(offset_ms))
    assert count - 1 <= len(found) <= count
    times = [views.t_ns for views in found]
    assert times == sorted(set(times))
    for views in found:
        for view in views.views:
            assert 0.0 < view.weight <= 1.0
            if view.weight == 1.0:
                assert view.current.capture_ns == views.t_ns
            else:
                blend = (1 - view.weight) * view.previous.capture_ns + view.weight * view.current.capture_ns
                assert blend == pytest.approx(views.t_ns, abs=1)
                assert view.previous.capture_ns < views.t_ns < view.current.capture_ns


def test_the_instant_is_the_newest_that_all_cameras_enclose():
    found = feed_all(pairing(("a", "b", "c")), [(100, 0), (104, 1), (109, 2), (133, 0), (137, 1), (142, 2)])
    assert found[-1].t_ns == 133 * NS_PER_MS
    assert [view.weight for view in found[-1].views] == pytest.approx([1.0, 29 / 33, 24 / 33])


def blob(x_px):
    """A soft blob at a sub-pixel position."""
    u, v = np.meshgrid(np.arange(200.0), np.arange(60.0))
    return (250 * np.exp(-((u - x_px) ** 2 + (v - 30) ** 2) / 50)).astype(np.uint8)


def centroid_px(image):
    moments = cv2.moments(image.astype(np.float32))
    return moments["m10"] / moments["m00"]


def test_interpolation_recovers_where_a_moving_blob_was():
    speed_px_ms, offset_ms = 0.6, 12.0
    jitter = np.random.default_rng(2).uniform(-2.0, 2.0, (6, 2))
    pair = pairing()
    interpolated = 0
    for t_ms, camera in events(offset_ms, jitter=jitter):
        views = pair.feed(camera, frame(t_ms, image=blob(20 + speed_px_ms * (t_ms - 90))))
        if views is None:
            continue
        truth_px = 20 + speed_px_ms * (views.t_ns / NS_PER_MS - 90)
        for view in views.views:
            measured = centroid_px(view.current.image)
            if view.previous is not None:
                interpolated += 1
                measured = (1 - view.weight) * centroid_px(view.previous.image) + view.weight * measured
                # Taken as synchronous, the newest frame would be wrong by several pixels.
                assert abs(centroid_px(view.current.image) - truth_px) > 3.0
            assert measured == pytest.approx(truth_px, abs=0.15)
    assert interpolated >= 7


def test_each_instant_is_given_once_whatever_comes_again():
    pair = pairing()
    found = feed_all(pair, events(0.0, count=3))
    again = [pair.feed(camera, frame(t_ms)) for t_ms, camera in events(0.0, count=3)]
    assert len(found) == 3
    assert again == [None] * 6


def test_a_late_camera_of_another_rate_is_still_enclosed():
    # 60 Hz beside 30 Hz whose frames arrive 45 ms late: the instant lies well back in the fast one.
    arrivals = sorted(
        [(100 + 16.5 * k, 100 + 16.5 * k, 0) for k in range(10)] + [(152 + 33 * k, 107 + 33 * k, 1) for k in range(4)]
    )
    found = feed_all(pairing(), [(t_ms, camera) for _, t_ms, camera in arrivals])
    assert [views.t_ns // NS_PER_MS for views in found] == [107, 140, 173, 206]


def test_skew_beyond_the_limit_is_refused_with_the_name_of_the_laggard():
    pair = pairing(max_skew_ms=50.0)
    assert feed_all(pair, [(100, 0), (100, 1), (133, 0), (166, 0)]) != []
    assert pair.feed(0, frame(199)) is None
    assert pair.problem(200 * NS_PER_MS) == "camera right is 99 ms behind the others"
    assert pair.feed(1, frame(199)) is not None
    assert pair.problem(200 * NS_PER_MS) is None


@pytest.mark.parametrize(("period_ms", "is_slow"), [(125.0, True), (66.0, False)])
def test_cameras_too_slow_for_the_hand_are_named_with_their_rate_and_the_cure(period_ms, is_slow):
    pair = pairing()
    fed = events(0.0, count=6, period_ms=period_ms)
    feed_all(pair, fed)
    told = pair.problem(round(fed[-1][0] * NS_PER_MS))
    if is_slow:
        assert told.startswith("camera left gives a picture only each 125 ms, the limit is 100 ms: let it give 20")
    else:
        assert told is None


@pytest.mark.parametrize(("wait_ms", "is_slow"), [(250.0, False), (210.0, True)])
def test_who_waits_longer_for_views_may_have_slower_cameras(wait_ms, is_slow):
    pair = pairing(longest_wait_ms=wait_ms)
    fed = events(0.0, count=6, period_ms=200.0)
    feed_all(pair, fed)
    told = pair.problem(round(fed[-1][0] * NS_PER_MS))
    if is_slow:
        assert told.startswith("camera left gives a picture only each 200 ms, the limit is 210 ms: let it give 10 a")
        assert told.endswith("or set a longer capture.longest_wait_ms here and safety.t_soft_ms at the remote site")
    else:
        assert told is None


def test_a_lost_frame_makes_no_slow_camera():
    pair = pairing()
    feed_all(pair, [(t_ms, camera) for t_ms in (100, 133, 266, 400) for camera in (0, 1)])
    assert pair.problem(400 * NS_PER_MS) is None


def test_a_silent_camera_is_stale():
    pair = pairing(start_ms=0.0)
    assert pair.problem(400 * NS_PER_MS) is None
    assert pair.problem(700 * NS_PER_MS) == "camera left gives no frames for 0.7 s"
    feed_all(pair, events(0.0, count=2))
    assert pair.problem(200 * NS_PER_MS) is None
    pair.feed(0, frame(800))
    assert pair.problem(800 * NS_PER_MS) == "camera right gives no frames for 0.7 s"


def test_a_frozen_camera_is_refused_until_its_picture_changes():
    pair = pairing(frozen_frames=3)
    given = []
    for k in range(6):
        t_ms = 100 + k * PERIOD_MS
        pair.feed(0, frame(t_ms))
        given.append(pair.feed(1, frame(t_ms, image=picture(0))))
    assert [views is not None for views in given] == [True, True, True, False, False, False]
    assert pair.problem(270 * NS_PER_MS) == "camera right gave 6 identical frames: frozen"
    pair.feed(0, frame(298.0))
    assert pair.feed(1, frame(298.0)) is not None
    assert pair.problem(298 * NS_PER_MS) is None


def test_three_cameras_in_step_are_taken_as_they_are():
    steps = [(100 + k * PERIOD_MS, camera) for k in range(4) for camera in range(3)]
    views = feed_all(pairing(("left", "right", "third")), steps)
    assert [[view.weight for view in v.views] for v in views] == [[1.0] * 3] * 4


def test_a_third_camera_out_of_step_is_interpolated_and_its_silence_told():
    pair = pairing(("left", "right", "third"))
    steps = [(100 + k * PERIOD_MS + (12 if camera == 2 else 0), camera) for k in range(5) for camera in range(3)]
    views = feed_all(pair, steps)
    assert len(views) >= 4
    for v in views:
        exposed = [(view.previous or view.current).capture_ns for view in v.views]
        assert max(exposed) <= v.t_ns <= min(view.current.capture_ns for view in v.views)
    for k in range(5, 12):
        for camera in range(2):
            pair.feed(camera, frame(100 + k * PERIOD_MS))
    assert "camera third" in pair.problem(round((100 + 11 * PERIOD_MS) * NS_PER_MS))
