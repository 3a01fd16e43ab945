"""The local site's loop, from views to samples: the drift alarm reaches the log once and every sample."""

import numpy as np
import pytest
from structlog.testing import capture_logs

import local_site.runtime.loop
from common.cameras.camera import Frame
from common.clock import NS_PER_S, FakeClock
from common.link.transport import Link
from common.messages.hand import TrackingStatus
from local_site.acquisition.capture import Capture
from local_site.acquisition.rig_cameras import OperatorRig
from local_site.authority.lease_client import Authority, LeaseAndClock
from local_site.authority.remote_watch import RemoteWatch
from local_site.calibration.rig import Rig
from local_site.config import LocalConfig
from local_site.preview.preview import Preview, PreviewProcess
from local_site.runtime.loop import ArmTracking, LocalSite, SampleSender
from local_site.runtime.recorder_relay import RecorderRelay
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.tracker import ArmEstimate, View, Views

FPS = 30
BUMP_NS = 15 * NS_PER_S
IMAGE = np.full((4, 6), 8, np.uint8)
PAIR = exact_rig(StereoConfig())


class Cameras(Capture):
    """Views of a number of cameras, one instant after another."""

    ended, longest_wait_s = False, 0.1

    def __init__(self, count):
        self._count, self._seq = count, 0

    def next(self, _timeout_s):
        self._seq += 1
        t_ns = self._seq * NS_PER_S // FPS
        return Views(t_ns, tuple(View(Frame(IMAGE, t_ns, self._seq)) for _ in range(self._count)))


class Wire(Link):
    """A link that keeps what is sent and never receives anything."""

    def __init__(self):
        self.sent = []

    def publisher(self, *_, **_named):
        return self

    def latest(self, *_, **_named):
        return self

    def serve(self, *_, **_named):
        return self

    def poll(self, *_):
        pass

    def put(self, sample):
        self.sent.append(sample)

    def take(self):
        return None


class Alone(Authority):
    """A site without a lease."""

    session = 1

    def __init__(self):
        """Without a link."""

    def lease_and_clock(self, _now_ns, _captured_ns=None):
        return LeaseAndClock()


class NoDrawing(PreviewProcess):
    """Draws nothing."""

    def __init__(self):
        """Without a process."""

    def take(self):
        return []


class BumpedLater:
    """A tracker whose views stop to fit together when a camera is bumped."""

    def track(self, views):
        residual_px = 0.5 if views.t_ns < BUMP_NS else 4.0
        return ArmEstimate(views.t_ns, TrackingStatus.TRACKED, "", wrist=np.zeros(3), residual_px=residual_px)


@pytest.fixture
def site(monkeypatch):
    """Makes a site with this many cameras, and the wire that it sends on."""

    def make(cameras=2):
        monkeypatch.setattr(local_site.runtime.loop, "make_tracker", lambda *_: BumpedLater())
        wire = Wire()
        rig = Rig(PAIR.cameras * (cameras // 2), PAIR.volume_min, PAIR.volume_max, PAIR.error_rms, "made up")
        operator = OperatorRig(rig, LocalConfig().tracking, (), lambda _t_ns: None)
        config, clock = LocalConfig(), FakeClock(0)
        watch, preview = RemoteWatch(wire.latest(), Alone.session, operator.engaged), Preview({}, NoDrawing(), 12.0)
        tracking, sender = ArmTracking(config, operator, wire), SampleSender(config, wire, Alone(), watch, clock)
        relay = RecorderRelay(config, wire, Alone())
        return LocalSite(Cameras(cameras), tracking, sender, watch, preview, relay, clock), wire

    return make


def test_drift_is_logged_once_and_told_with_every_sample(site):
    made, wire = site()
    with capture_logs() as logs:
        for _ in range(30 * FPS):
            made.step()
    warned = [entry for entry in logs if entry["event"] == "drift"]
    assert len(warned) == 1
    assert "calibrate again" in warned[0]["reason"]
    told = [sample.capture_ns for sample in wire.sent if sample.reason.endswith("calibrate again")]
    assert BUMP_NS < told[0] < BUMP_NS + 11 * NS_PER_S
    assert told == [sample.capture_ns for sample in wire.sent if sample.capture_ns >= told[0]]
    assert wire.sent[-1].status is TrackingStatus.TRACKED


def test_the_views_of_all_cameras_are_saved(site, tmp_path):
    made, _ = site(cameras=4)
    made.step()
    made.save_views(tmp_path)
    names = ("left", "right", "third", "fourth")
    assert {path.name for path in tmp_path.iterdir()} == {f"operator_{name}.png" for name in names}
