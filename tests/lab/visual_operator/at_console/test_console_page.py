"""The operator's page: what a real console sends, and what is shown of it."""

import time

import msgspec
import numpy as np
import pytest

from common.clock import ClockOffset
from common.messages.hand import Locks, OperatorSettings
from common.messages.robot import GripperStatus, HandLink, LeaseState, SessionState
from lab.measure.page import scene
from lab.visual_operator.at_console.console_page import ConsolePage
from lab.visual_operator.at_console.page_connection import changed
from local_site.console.model.frames import view_frame
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.seat import Seat, Visitor
from local_site.console.model.situation import NewestMessages, situation_json
from remote_site.video.streaming.pictures import encode_jpeg
from tests.present import present

OFFSET = ClockOffset(0, 0)
LINK = HandLink(age_ms=40.0, network_ms=7.0, clock_ms=1.0, tracking_ms=32.0, interval_ms=33.0, jitter_ms=0.0, loss=0.0)


def situation(state=None, hand=None, settings=None, page=1):
    """As a console sends it."""
    now_ns, seat = time.monotonic_ns(), Seat(open_=True)
    seat.arrive(Visitor(page, "here"), now_ns)
    newest = NewestMessages(state, now_ns, hand, now_ns)
    return situation_json(now_ns, newest, None, None, seat, settings, Latencies(), History())


def picture(camera, level, size=scene.SIZE, seq=1):
    jpeg = encode_jpeg(np.full((*size, 3), level, np.uint8), 80)
    return view_frame(f"camera/{camera}", scene.picture(camera, seq, jpeg), OFFSET).payload


def opened():
    """A page that has been greeted and knows the cell."""
    page = ConsolePage()
    page.take_text(msgspec.json.encode({"type": "hello", "page": 1, "operate": True, "operator": "anna"}).decode())
    page.take_text(msgspec.json.encode({"type": "cell", "cell": msgspec.to_builtins(scene.cell())}).decode())
    return page


@pytest.fixture
def page():
    """A page with everything on it."""
    page = opened()
    state = scene.state(SessionState.ENGAGED, "ok", "the arm follows the hand", hand_link=LINK)
    page.take_text(situation(state, scene.hand(), OperatorSettings(lease=5, scale=0.5)))
    for camera in scene.CAMERAS:
        page.take_picture(picture(camera, 90), time.monotonic_ns())
    return page


def test_what_the_page_shows_is_what_the_console_sent(page):
    shown = page.shown(123)
    assert (shown.t_ns, shown.state, shown.code, shown.opening_m) == (123, SessionState.ENGAGED, "ok", 0.05)
    assert (shown.gripper, shown.delay_s, shown.assist) == (GripperStatus.HOLDING, 0.007, None)
    assert set(shown.views) == set(scene.CAMERAS)
    calibrations = {camera.name: camera.calibration for camera in scene.cell().cameras}
    for name, view in shown.views.items():
        assert abs(int(view.picture.mean()) - 90) <= 1
        assert view.projection.ravel().tolist() == list(present(calibrations[name]).projection)
        assert view.on_tool is present(calibrations[name]).on_tool
        assert 0 < time.monotonic_ns() - view.capture_ns < 60e9
    assert page.cell.mapping == scene.cell().mapping
    assert page.settings.scale == 0.5


def test_a_smaller_picture_is_shown_in_the_size_that_its_projection_is_for(page):
    page.take_picture(picture("side", 200, size=(240, 320), seq=2), time.monotonic_ns())
    shown = page.shown(0).views["side"].picture
    assert shown.shape == (*scene.SIZE, 3)
    assert abs(int(shown.mean()) - 200) <= 1


def test_each_picture_is_reported_as_a_page_does(page):
    assert set(page.painted) == {f"camera/{camera}" for camera in scene.CAMERAS}
    assert all(painted.seq == 1 and painted.age_ms >= 0 for painted in page.painted.values())


@pytest.mark.parametrize("name", ["preview/left", "camera/another"])
def test_other_pictures_are_only_acknowledged(page, name):
    before = page.shown(0).views
    frame = scene.picture("left", 1, scene.plain(5))
    assert page.take_picture(view_frame(name, frame, OFFSET).payload, 0) == name
    assert page.shown(0).views == before


def test_a_picture_of_unknown_age_is_not_shown():
    page = opened()
    payload = view_frame("camera/side", scene.picture("side", 1, scene.plain(5)), None).payload
    assert page.take_picture(payload, 0) == "camera/side"
    assert page.painted == {}


def test_the_operator_begins_once_nothing_lacks(page):
    assert page.lacks() == ""
    settings, hand = OperatorSettings(lease=5), scene.hand()
    state = scene.state(SessionState.DISENGAGED, "not_engaged", "")
    other = scene.state(SessionState.DISENGAGED, "", "", lease=LeaseState(6, "berta", 8, state.t_ns, None))
    for text, word in (
        (situation(state, hand, settings, page=2), "controls"),
        (situation(None, hand, settings), "state"),
        (situation(state, hand, None), "lease"),
        (situation(other, hand, settings), "lease"),
        (situation(state, None, settings), "tracked"),
    ):
        page.take_text(text)
        assert word in page.lacks()


def test_without_all_pictures_there_is_nothing_to_look_at():
    page = opened()
    page.take_text(situation(scene.state(SessionState.DISENGAGED, "", ""), scene.hand(), OperatorSettings(lease=5)))
    page.take_picture(picture("side", 9), 0)
    assert page.shown(0) is None
    assert "pictures" in page.lacks()


def test_only_what_differs_is_set():
    shown = OperatorSettings(lease=5, revision=3, scale=0.5)
    assert changed(shown, OperatorSettings(lease=1, revision=1, scale=0.5)) == {}
    assert changed(None, shown) == {}
    wanted = OperatorSettings(scale=0.25, locks=Locks(roll=True))
    assert changed(shown, wanted) == {"scale": 0.25, "locks": {"roll": True}}
