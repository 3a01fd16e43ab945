"""Through links of 20 and 5 Mbit/s the pictures stay young and the cameras equal, and a free link gets full quality."""

from collections import Counter

import numpy as np
import pytest

from common.messages.video import (
    CameraStatus,
    Codec,
    VideoFrame,
    ViewCame,
    ViewShown,
    ViewsShown,
)
from lab.measure.video.link import REPORT_NS, StreamRun
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.adaptation import Adaptation, fair_limit
from remote_site.video.streaming.encoding import Encoded
from remote_site.video.streaming.page_rate import LEAST_FPS
from remote_site.video.streaming.sent_pictures import SentPictures
from remote_site.video.streaming.setting import StreamSetting, fit
from tests.present import present

MS = 1_000_000
FULL = StreamSetting(80, 1.0, 30.0)
CONFIG = VideoConfig()
# Cameras unlike each other, and unlike the table that the adaptation goes by: 29 Mbit/s at full quality together.
FULL_BYTES = {"front_high": 22_000, "front_low": 24_000, "side": 45_000, "gripper": 30_000}
QUALITIES, SIZES = (10, 30, 50, 70, 80, 100), (0.3, 0.4, 0.48, 0.68, 1.0, 5.0)


def pictures(seed=1):
    rng = np.random.default_rng(seed)

    def make(camera, _seq, setting):
        size = FULL_BYTES[camera] * np.interp(setting.quality, QUALITIES, SIZES) * setting.scale**1.9
        return Encoded(Codec.JPEG, True, 1, 1, bytes(int(size * rng.uniform(0.9, 1.1))))

    return make


def ages_ms(arrivals):
    return np.array([arrival.age_ms for arrival in arrivals])


def mbit_s(arrivals, seconds):
    return 8e-6 * sum(arrival.size for arrival in arrivals) / seconds


def shares(arrivals):
    total = Counter[str]()
    for arrival in arrivals:
        total[arrival.camera] += arrival.size
    return total


def settings(run):
    return [run.adaptation.setting(camera, run.now_ns) for camera in FULL_BYTES]


@pytest.mark.parametrize("mbit", [20.0, 5.0])
def test_pictures_stay_young_and_cameras_equal(mbit):
    run = StreamRun(CONFIG, pictures(), mbit)
    run.run(5.0)
    arrivals = run.run(30.0)
    ages, total = ages_ms(arrivals), shares(arrivals)
    assert np.median(ages) < 100.0
    assert np.percentile(ages, 95) < 300.0
    assert ages.max() < (300.0 if mbit == 20.0 else 450.0)
    assert set(total) == set(FULL_BYTES)
    assert max(total.values()) < 1.3 * min(total.values())
    assert 0.6 < mbit_s(arrivals, 30.0) / mbit < 0.9


def test_without_adaptation_the_same_link_makes_pictures_old():
    run = StreamRun(CONFIG, pictures(), 20.0, reports=False)
    assert ages_ms(run.run(5.0)).max() > 1000.0


def test_a_free_link_carries_full_quality():
    run = StreamRun(CONFIG, pictures(), 100.0)
    run.run(1.0)
    for _ in range(100):
        run.run(0.1)
        assert settings(run) == [FULL] * 4


def test_a_link_that_becomes_narrow_is_followed_within_seconds():
    run = StreamRun(CONFIG, pictures(), 20.0)
    run.run(10.0)
    run.link.mbit_s = 5.0
    worst = ages_ms(run.run(2.0)).max()
    assert worst < 1200.0
    arrivals = run.run(8.0)
    assert np.percentile(ages_ms(arrivals), 95) < 300.0


@pytest.mark.parametrize("mbit", [5.0, 20.0])
def test_a_link_that_becomes_free_again_carries_full_quality_within_seconds(mbit):
    run = StreamRun(CONFIG, pictures(), mbit)
    run.run(10.0)
    assert settings(run) != [FULL] * 4
    run.link.mbit_s = 1000.0
    run.run(7.0)
    assert settings(run) == [FULL] * 4


def test_a_link_that_was_full_before_the_console_reported_is_emptied():
    run = StreamRun(CONFIG, pictures(), 20.0)
    run.viewer.reports = False
    run.run(2.0)
    run.viewer.reports = True
    run.run(6.0)
    assert np.percentile(ages_ms(run.run(10.0)), 95) < 300.0


def view(seq, age_ms, lag_ms=15.0, painted_fps=30.0):
    came = ViewCame(seq=seq, age_ms=age_ms, fps=30.0)
    return ViewShown(seq=seq, capture_ns=0, age_ms=age_ms + lag_ms, fps=painted_fps, came=came)


def shown(session, now_ns, seq=0, age_ms=50.0, cameras=FULL_BYTES):
    views = {name: view(seq, age_ms) for name in cameras}
    return ViewsShown(session=session, lease=0, h264=False, sent_ns=now_ns, views=views)


def frame(camera, seq, size=20_000, capture_ns=0):
    return VideoFrame(
        camera=camera,
        seq=seq,
        capture_ns=capture_ns,
        capture_estimated=False,
        status=CameraStatus.LIVE,
        reason="",
        width=1,
        height=1,
        codec=Codec.JPEG,
        key=True,
        data=bytes(size),
    )


def late(adaptation, session, start_ns, reports=10):
    """A console to which all comes later and later; the time of its last word."""
    for k in range(reports):
        now_ns = start_ns + k * REPORT_NS
        for camera in FULL_BYTES:
            adaptation.sent(frame(camera, session * 100 + k, capture_ns=now_ns), now_ns)
        adaptation.update(shown(session, now_ns, session * 100 + k, 50.0 + 100.0 * k), now_ns)
    return start_ns + (reports - 1) * REPORT_NS


def test_without_a_console_all_is_sent_at_full_quality():
    adaptation = Adaptation(CONFIG, h264=False)
    for k in range(300):
        adaptation.sent(frame("side", k), k * 33 * MS)
        assert adaptation.setting("side", k * 33 * MS) == FULL


def test_who_has_just_begun_to_listen_gets_little_until_it_reports_or_for_three_seconds():
    adaptation = Adaptation(CONFIG, h264=False)
    adaptation.listened(0, has_listener=False)
    assert adaptation.setting("side", 0).fps == LEAST_FPS
    adaptation.listened(100 * MS, has_listener=True)
    for now_ns in range(100 * MS, 3100 * MS, 50 * MS):
        adaptation.listened(now_ns, has_listener=True)
        setting = adaptation.setting("side", now_ns)
        assert setting.fps * setting.relative_bytes < 0.1 * FULL.fps * FULL.relative_bytes
    assert adaptation.setting("side", 3100 * MS) == FULL


def test_a_console_that_has_reported_gets_what_its_link_carries_at_once():
    adaptation = Adaptation(CONFIG, h264=False)
    adaptation.listened(0, has_listener=False)
    adaptation.listened(100 * MS, has_listener=True)
    for k in range(20):
        now_ns = (100 + 100 * k) * MS
        for camera in FULL_BYTES:
            adaptation.sent(frame(camera, k, capture_ns=now_ns), now_ns)
        adaptation.update(shown(1, now_ns, k), now_ns)
    assert adaptation.setting("side", now_ns) == FULL


def test_a_console_that_falls_silent_counts_for_a_second():
    adaptation = Adaptation(CONFIG, h264=False)
    last_ns = late(adaptation, 1, 0)
    assert adaptation.setting("side", last_ns + 900 * MS) != FULL
    assert adaptation.setting("side", last_ns + 1100 * MS) == FULL


def test_the_newest_console_counts_and_an_older_one_does_not_until_it_is_silent():
    adaptation = Adaptation(CONFIG, h264=False)
    now_ns = late(adaptation, 1, 0)
    assert adaptation.setting("side", now_ns) != FULL
    for k in range(6):
        now_ns += REPORT_NS
        for camera in FULL_BYTES:
            adaptation.sent(frame(camera, 300 + k, capture_ns=now_ns), now_ns)
        adaptation.update(shown(2, now_ns, 300 + k), now_ns)
    assert adaptation.setting("side", now_ns) == FULL
    now_ns = late(adaptation, 1, now_ns + 10 * MS, reports=8)
    assert adaptation.setting("side", now_ns) == FULL
    now_ns = late(adaptation, 1, now_ns + 2000 * MS)
    assert adaptation.setting("side", now_ns) != FULL


def test_cameras_that_this_cell_has_not_and_old_news_change_nothing():
    adaptation = Adaptation(CONFIG, h264=False)
    for k in range(20):
        adaptation.update(shown(1, k * REPORT_NS, seq=7, age_ms=5000.0 * k, cameras=("roof",)), k * REPORT_NS)
        adaptation.update(shown(1, k * REPORT_NS, seq=0, age_ms=0.0), k * REPORT_NS)
    assert adaptation.setting("side", 20 * REPORT_NS) == FULL


def setting_after(told):
    """The side camera's setting after 30 reports, in which some cameras report something else (by number of report)."""
    adaptation = Adaptation(CONFIG, h264=False)
    for k in range(30):
        now_ns = k * REPORT_NS
        for camera in FULL_BYTES:
            adaptation.sent(frame(camera, k, 2000, now_ns - 50 * MS), now_ns - 50 * MS)
        word = shown(1, now_ns, k)
        word.views.update({camera: tell(k) for camera, tell in told.items()})
        adaptation.update(word, now_ns)
    return adaptation.setting("side", now_ns)


def test_one_late_camera_is_no_late_link():
    assert setting_after({"side": lambda k: view(k, 50.0 + 60.0 * k)}) == FULL


def test_pictures_that_are_late_for_a_moment_though_all_arrive_are_not_the_links_fault():
    adaptation = Adaptation(CONFIG, h264=False)
    for k in range(60):
        now_ns = k * REPORT_NS
        for camera in FULL_BYTES:
            adaptation.sent(frame(camera, k, 2000, now_ns - 50 * MS), now_ns - 50 * MS)
        adaptation.update(shown(1, now_ns, k, 250.0 if k % 10 in {7, 8, 9} else 50.0), now_ns)
        if k > 5:
            setting = adaptation.setting("side", now_ns)
            assert (setting.quality, setting.scale) == (FULL.quality, FULL.scale)
            assert setting.fps >= 0.6 * FULL.fps


@pytest.mark.slow
@pytest.mark.parametrize("paints_fps", [8.0, 15.0, 22.0])
def test_a_page_that_is_too_slow_gets_fewer_pictures_but_good_ones_and_all_again_when_it_is_quick(paints_fps):
    run = StreamRun(CONFIG, pictures(), 100.0)
    run.viewer.paints_fps = paints_fps
    run.run(12.0)
    rates, painted = [], len(run.run(20.0)) / 20.0 / 4
    for _ in range(20):
        run.run(0.5)
        rates += [setting.fps for setting in settings(run)]
        assert all((setting.quality, setting.scale) == (80, 1.0) for setting in settings(run))
    assert 0.6 * paints_fps < np.mean(rates) < 1.3 * paints_fps
    assert painted > 0.55 * paints_fps
    run.viewer.paints_fps = 1000.0
    run.run(18.0)
    assert settings(run) == [FULL] * 4


def test_a_page_that_paints_late_gets_fewer_pictures():
    late = {camera: lambda k: view(k, 50.0, lag_ms=150.0) for camera in FULL_BYTES}
    setting = setting_after(late)
    assert setting.fps < 30.0
    assert (setting.quality, setting.scale) == (80, 1.0)


def test_a_page_that_paints_later_than_it_did_gets_fewer_pictures():
    """Whatever it has always taken, as on a slow screen, is no reason."""
    as_ever = {camera: lambda _k: view(_k, 50.0, lag_ms=55.0) for camera in FULL_BYTES}
    assert setting_after(as_ever).fps == 30.0
    later = {camera: lambda k: view(k, 50.0, lag_ms=20.0 if k < 15 else 65.0) for camera in FULL_BYTES}
    assert setting_after(later).fps < 30.0


@pytest.mark.parametrize("holds_bytes", [400_000, 200_000])
def test_a_link_that_loses_what_it_cannot_hold_is_adapted_to_as_well(holds_bytes):
    run = StreamRun(CONFIG, pictures(), 5.0)
    run.link.holds_bytes = holds_bytes
    run.run(5.0)
    arrivals = run.run(20.0)
    total = shares(arrivals)
    assert np.percentile(ages_ms(arrivals), 95) < 300.0
    assert max(total.values()) < 1.3 * min(total.values())


@pytest.mark.parametrize(
    ("wanted", "budget", "limit"),
    [([10, 10], 10, 5), ([1, 10, 10], 9, 4), ([1, 2, 30], 12, 9), ([1, 1], 10, 8), ([], 5, 5)],
)
def test_what_one_camera_does_not_need_goes_to_the_others(wanted, budget, limit):
    assert fair_limit(wanted, budget) >= limit
    assert sum(min(wants, fair_limit(wanted, budget)) for wants in wanted) == pytest.approx(min(sum(wanted), budget))


@pytest.mark.parametrize("full", [FULL, StreamSetting(95, 1.0, 60.0), StreamSetting(30, 1.0, 10.0)])
def test_fewer_bytes_never_give_a_better_picture_and_are_kept_to(full):
    before = (0.0, 0)
    for rate in np.geomspace(1e3, 1e7, 200):
        setting = fit(rate, 20_000.0, full, full)
        taken = 20_000.0 * setting.relative_bytes * setting.fps
        assert taken <= max(1.02 * rate, 20_000.0 * StreamSetting(20, 0.5, 2.0).relative_bytes * 2.0 * 1.02)
        assert 1 <= setting.quality <= full.quality
        assert setting.fps <= full.fps
        now = (setting.scale * setting.fps, setting.quality)
        assert now[0] >= before[0]
        assert now > before or now[0] == before[0]
        before = now
    assert setting == full


def test_sent_pictures_are_counted_as_what_came_and_what_waits():
    sent = SentPictures()
    for seq in range(6):
        sent.send(frame("side", seq, 1000 + seq, capture_ns=seq * 10 * MS), FULL, (10 * seq + 5) * MS)
    first = present(sent.come(ViewCame(seq=0, age_ms=45.0, fps=30.0), 50 * MS))
    assert (first.sent_bytes, first.carried_bytes, first.waiting_bytes) == (0, 0, 1001 + 1002 + 1003 + 1004)
    assert (first.delay_ms, first.round_trip_ms, first.overdue_ms) == (40.0, 45.0, 35.0)
    sent.send(frame("side", 6, 1006, capture_ns=60 * MS), FULL, 65 * MS)
    news = present(sent.come(ViewCame(seq=2, age_ms=45.0, fps=30.0), 70 * MS))
    assert (news.sent_bytes, news.carried_bytes, news.waiting_bytes) == (1006, 1001 + 1002, 1003 + 1004 + 1005 + 1006)
    none = present(sent.come(ViewCame(seq=2, age_ms=45.0, fps=30.0), 170 * MS))
    assert (none.sent_bytes, none.carried_bytes, none.overdue_ms) == (0, 0, 135.0)
    assert sent.come(ViewCame(seq=1, age_ms=45.0, fps=30.0), 170 * MS) is None
    assert present(sent.come(ViewCame(seq=4, age_ms=95.0, fps=30.0), 170 * MS)).delay_ms == 90.0


def test_of_bytes_that_were_dropped_on_the_way_only_the_share_that_came_is_carried():
    sent = SentPictures()
    for seq in range(21):
        sent.send(frame("side", seq, 1000), FULL, 10 * seq * MS)
    sent.come(ViewCame(seq=0, age_ms=45.0, fps=1.0), 50 * MS)
    assert present(sent.come(ViewCame(seq=20, age_ms=45.0, fps=5.0), 300 * MS)).carried_bytes == 5000
