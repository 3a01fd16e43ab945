"""Clicks on the joints: they reach the tracker of one camera, which begins there; other trackers refuse them."""

import pytest

from common.cameras.camera import Frame
from common.messages.hand import TrackingStatus
from common.messages.requests import JointsRequest
from local_site.runtime.joint_clicks import JointClicks
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hazel import TexturedOperator, film_camera, first_joints_px
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import View, Views


class Waiting:
    """A console that asks once."""

    def __init__(self, **joints):
        self.request = JointsRequest(id=4, deadline_ns=10**9, **joints)
        self.replies = []

    def poll(self, _now_ns, handle):
        self.replies.append(handle(self.request))


def clicked(**moved):
    return {name: (u / 640, v / 480) for name, (u, v) in {**first_joints_px(), **moved}.items()}


def views(t_s):
    picture = TexturedOperator(0.0).render(t_s)[0]
    assert picture.shape[:2] == (480, 640)
    return Views(round(t_s * 1e9), (View(Frame(picture, round(t_s * 1e9), 0)),))


def seen(tracker, t_s):
    return tracker.track(views(t_s))


@pytest.mark.slow
def test_tracking_begins_where_the_joints_are_clicked_and_begins_anew_with_every_click():
    tracker = make_tracker(film_camera(), TrackingConfig(method="monocular"))
    assert "click them" in seen(tracker, 0.0).reason
    asked = Waiting(**clicked())
    clicks = JointClicks(asked, tracker)
    clicks.poll(None, 0)
    clicks.poll(views(0.0), 0)
    assert [(r.done, r.code) for r in asked.replies] == [(False, "no_picture"), (True, "ok")]
    assert seen(tracker, 0.0).status is TrackingStatus.TRACKED
    assert seen(tracker, 1 / 30).status is TrackingStatus.TRACKED
    JointClicks(Waiting(**clicked(wrist=(310.0, 250.0))), tracker).poll(views(2 / 30), 0)
    refused = seen(tracker, 2 / 30)
    assert refused.status is TrackingStatus.LOST
    assert "parallel to the picture" in refused.reason


def test_a_tracker_that_finds_the_arm_by_itself_refuses():
    rig = exact_rig(SimulationConfig().stereo)
    asked = Waiting(**clicked())
    JointClicks(asked, make_tracker(rig, TrackingConfig())).poll(None, 0)
    assert [(r.done, r.code) for r in asked.replies] == [(False, "no_joints")]
