"""Whatever a console reports, and however its clock runs, pictures go on: settings stay possible, nothing raises."""

import random

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.codec import decode, encode
from common.messages.video import Codec, ViewCame, ViewShown, ViewsShown
from lab.measure.video.link import StreamRun, live_frame
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.adaptation import Adaptation
from remote_site.video.streaming.encoding import Encoded

CONFIG = VideoConfig()
CAMERAS = tuple(camera.name for camera in CONFIG.cameras)
COUNTS = 0, 1, 10**6, 10**9, 10**15, 2**53, 2**62, 2**63 - 1
FLOATS = 0.0, -0.0, 5e-324, 1e-9, 0.5, 30.0, 1e6, 1e12
SLEWS = 0.03, 0.083, -0.03, -0.083


class SlewedRun(StreamRun):
    """The operator's clock gains `slew` of the time, as its console's stamps do; `back_and_forth_s` turns that round.

    The ages that the console tells are by an offset that was measured up to `behind_s` ago.
    """

    def __init__(self, slew: float, back_and_forth_s: float, mbit_s: float = 20.0, behind_s: float = 1.0) -> None:
        super().__init__(CONFIG, lambda _c, _n, setting: picture(setting.quality), mbit_s)
        self._slew, self._turn_s = slew, back_and_forth_s
        self.own_ns = 0.0
        update, before = self.adaptation.update, [0]

        def slewed(report, now_ns):
            forth = (now_ns / NS_PER_S) % (2 * self._turn_s) < self._turn_s
            gain = self._slew if forth else -self._slew
            self.own_ns += (now_ns - before[0]) * (1 + gain)
            before[0] = now_ns
            update(self._told(report, gain * behind_s * 1e3), now_ns)

        self.adaptation.update = slewed  # type: ignore[method-assign]

    def _told(self, report, error_ms):
        def aged(view):
            came = msgspec.structs.replace(view.came, age_ms=max(0.0, view.came.age_ms + error_ms))
            return msgspec.structs.replace(view, age_ms=max(0.0, view.age_ms + error_ms), came=came)

        views = {name: aged(view) for name, view in report.views.items()}
        return msgspec.structs.replace(report, sent_ns=round(self.own_ns), views=views)


def picture(quality):
    return Encoded(Codec.JPEG, True, 640, 480, bytes(100 + 200 * quality))


def possible(setting):
    return 1 <= setting.quality <= 100 and 0 < setting.scale <= 1 and 0 < setting.fps <= CONFIG.fps


@pytest.mark.slow
@pytest.mark.parametrize("slew", SLEWS)
@pytest.mark.parametrize("back_and_forth_s", [1e6, 3.0])
def test_an_operators_clock_that_is_slewed_leaves_the_pictures_going(slew, back_and_forth_s):
    run = SlewedRun(slew, back_and_forth_s)
    run.run(5.0)
    arrivals = run.run(25.0)
    assert len(arrivals) > 25.0 * 5.0 * len(CAMERAS) * 0.5
    assert np.percentile([one.age_ms for one in arrivals], 95) < 500.0
    assert all(possible(run.adaptation.setting(camera, run.now_ns)) for camera in CAMERAS)


def hostile_report(chance, now_ns):
    """A report that the wire accepts."""

    def count():
        return chance.choice((*COUNTS, now_ns, max(0, now_ns + round(chance.gauss(0, 1e9)))))

    def view():
        came = ViewCame(
            seq=count() if chance.random() < 0.3 else chance.randrange(200),
            age_ms=chance.choice(FLOATS),
            fps=chance.choice(FLOATS[:-1]),
        )
        return ViewShown(
            seq=count(), capture_ns=count(), age_ms=chance.choice(FLOATS), fps=chance.choice(FLOATS[:-1]), came=came
        )

    names = chance.sample((*CAMERAS, "another", "x" * 64), chance.randrange(5))
    shown = ViewsShown(
        session=chance.choice((1, 1, 1, 2)),
        sent_ns=count(),
        lease=0,
        h264=chance.random() < 0.5,
        views={name: view() for name in names},
    )
    return decode(encode(shown), ViewsShown, 4096)


@pytest.mark.slow
@pytest.mark.parametrize("h264", [False, True])
@pytest.mark.parametrize("seed", range(8))
def test_any_report_that_the_wire_accepts_leaves_settings_that_can_be_used(seed, h264):
    chance = random.Random(seed)  # noqa: S311  # reports to try, the same each time
    adaptation, now_ns = Adaptation(CONFIG, h264=h264), 5 * NS_PER_S
    for seq in range(400):
        now_ns += round(chance.choice((1, 33, 100, 900)) * NS_PER_MS)
        for camera in CAMERAS:
            setting = adaptation.setting(camera, now_ns)
            assert possible(setting)
            sent = picture(setting.quality)._replace(codec=setting.codec)
            adaptation.sent(live_frame(camera, seq, max(0, now_ns - 20 * NS_PER_MS), sent), now_ns)
        adaptation.update(hostile_report(chance, now_ns), now_ns)
        narrow = adaptation.trouble(now_ns)
        assert narrow is None or np.isfinite((narrow.carries_mbit_s, narrow.needs_mbit_s)).all()


def test_a_report_about_a_picture_is_never_older_than_the_picture():
    """A console whose clock was far ahead at first, and lost a minute since, would have told before it was asked."""
    adaptation, now_ns = Adaptation(CONFIG, h264=False), 100 * NS_PER_S
    for seq in range(40):
        now_ns += 100 * NS_PER_MS
        adaptation.sent(live_frame("side", seq, now_ns, picture(80)), now_ns)
        came = ViewCame(seq=seq, age_ms=20.0, fps=10.0)
        shown = ViewShown(seq=seq, capture_ns=now_ns, age_ms=40.0, fps=10.0, came=came)
        sent_ns = now_ns + 60 * NS_PER_S - 2 * NS_PER_S * seq
        adaptation.update(ViewsShown(session=1, sent_ns=sent_ns, lease=0, h264=False, views={"side": shown}), now_ns)
        assert possible(adaptation.setting("side", now_ns))
