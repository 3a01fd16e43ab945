"""Previews come at their pace, only for those who look, show what was found, and say so when there is nothing."""

import os
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
import simplejpeg
from structlog.testing import capture_logs

from common.cameras.camera import Frame
from common.messages.hand import TrackingStatus
from common.messages.video import CameraStatus
from local_site.preview.cropping import Cropping
from local_site.preview.preview import (
    Drawn,
    PictureInfo,
    Preview,
    PreviewConfig,
    PreviewProcess,
    decode_order,
    draw,
    encode_order,
)
from local_site.tracking.annotate import annotate
from local_site.tracking.tracker import ArmEstimate, Overlay, View, Views

MS = 1_000_000
CAMERA = np.array([[500.0, 0.0, 160.0, 0.0], [0.0, 500.0, 120.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
RNG = np.random.default_rng(2)
CONFIG = PreviewConfig()


def views(t_ns=33 * MS, count=2, colour=False):
    shape = (240, 320, 3) if colour else (240, 320)
    pictures = [np.asarray(RNG.integers(0, 60, shape), np.uint8) for _ in range(count)]
    return Views(t_ns, tuple(View(Frame(picture, t_ns + k, 0, True)) for k, picture in enumerate(pictures)))


def overlay(x):
    contour = np.array([[x, 20], [x + 80, 30], [x + 60, 200]], np.int32)
    line = np.array([[x, 40.5], [x + 50, 90.0]])
    return Overlay(contour, line, None, elbow=np.array([x, 50.0]), wrist=np.array([x + 9.5, 60.0]))


FOUND = ArmEstimate(
    t_ns=33 * MS,
    status=TrackingStatus.DEGRADED,
    reason="the thumb is behind the hand",
    elbow=np.array([0.1, 0.0, 0.2]),
    wrist=np.array([0.0, 0.1, 0.3]),
    thumb=np.array([0.0, 0.0, 0.4]),
    thumb_inferred=True,
    overlays=(overlay(100), overlay(150)),
    covariances={"wrist": 1e-5 * np.eye(3), "elbow": np.full((3, 3), np.inf)},
)
LOST = ArmEstimate(0, TrackingStatus.LOST, "no arm in view")
WITHOUT_RIGHTS = ["setpriv", "--bounding-set=-sys_nice"] if os.geteuid() == 0 else []
CLOSING = """
import os, resource, time
from local_site.preview.preview import PreviewConfig, PreviewProcess

resource.setrlimit(resource.RLIMIT_NICE, (0, 0))
process = PreviewProcess(PreviewConfig(), ())
child = process._child.process
while os.sched_getscheduler(child.pid) != os.SCHED_IDLE:
    time.sleep(0.01)
try:
    os.sched_setscheduler(child.pid, os.SCHED_OTHER, os.sched_param(0))
except PermissionError:
    print("refused")
process.close()
print("ended", child.exitcode)
"""


@pytest.mark.parametrize("estimate", [FOUND, LOST])
@pytest.mark.parametrize("colour", [False, True])
def test_what_is_drawn_elsewhere_is_what_would_be_drawn_here(estimate, colour):
    seen = views(colour=colour)
    order = decode_order(encode_order(seen, estimate))
    for k, view in enumerate(seen.views):
        here = annotate(view.current.image, estimate, k, CAMERA)
        assert (annotate(view.current.image, order.estimate, k, CAMERA) == here).all()


def test_the_drawing_keeps_stamps_and_shrinks_what_is_too_wide():
    seen = views()
    flat = [view.current.image.reshape(-1) for view in seen.views]
    order = decode_order(encode_order(seen, FOUND))
    small = draw(order, flat, (CAMERA, CAMERA), 70, Cropping(2, 160))
    assert [(d.width, d.height) for d in small] == [(160, 120)] * 2
    assert [simplejpeg.decode_jpeg(d.jpeg).shape for d in small] == [(120, 160, 3)] * 2
    assert [(d.taken.capture_ns, d.taken.capture_estimated) for d in small] == [(33 * MS, True), (33 * MS + 1, True)]
    as_it_is = draw(order, flat, (CAMERA, CAMERA), 70, Cropping(2, 640))
    assert [(d.width, d.height) for d in as_it_is] == [(320, 240)] * 2


SMALL = Overlay(contour=np.array([[96, 72], [208, 156]], np.int32))  # of 0.35 of the picture


def after_two_seconds(cameras):
    """The pictures of a run in which the arm was found at once."""
    cropping = Cropping(cameras, 640)
    for k in range(24):
        seen = views(k * 83 * MS, cameras)
        found = replace(FOUND, t_ns=seen.t_ns, overlays=(SMALL,) * cameras)
        flat = [view.current.image.reshape(-1) for view in seen.views]
        drawn = draw(decode_order(encode_order(seen, found)), flat, (CAMERA,) * cameras, 70, cropping)
    return drawn


def test_views_are_cropped_to_the_arm_unless_a_single_camera_sees_it():
    left, right = after_two_seconds(2)
    for view in (left, right):
        assert view.taken.shape == (240, 320)
        assert view.width / view.height == pytest.approx(4 / 3, abs=0.01)
        assert view.width == pytest.approx(0.51 * 320, abs=3)
        assert simplejpeg.decode_jpeg(view.jpeg).shape == (view.height, view.width, 3)
    (only,) = after_two_seconds(1)
    assert (only.width, only.height) == (320, 240)


class Wire:
    def __init__(self, has_listener=True):
        self.has_listener = has_listener
        self.sent = []

    def put(self, message):
        self.sent.append(message)


class QuickDrawer(PreviewProcess):
    """Has its pictures ready at the next look."""

    def __init__(self):
        self.orders = []
        self._ready = []

    def draw(self, seen, _estimate):
        self.orders.append(seen.t_ns)
        stamps = [view.current.capture_ns for view in seen.views]
        self._ready = [Drawn(PictureInfo((2, 3), stamp, False), 3, 2, b"jpeg") for stamp in stamps]

    def take(self):
        ready, self._ready = self._ready, []
        return ready


def shown(seconds, *wires, fps=12.0):
    drawer = QuickDrawer()
    preview = Preview(dict(zip(("left", "right"), wires, strict=True)), drawer, fps)
    for k in range(round(seconds * 30)):
        preview.show(views((k + 1) * 1000 * MS // 30), FOUND)
    return drawer, preview


def test_both_views_are_sent_at_the_configured_rate_with_their_exposure():
    left, right = Wire(), Wire()
    drawer, _ = shown(10.0, left, right)
    assert len(drawer.orders) == pytest.approx(120, abs=1)
    assert [m.seq for m in left.sent] == list(range(len(left.sent)))
    assert [m.capture_ns for m in left.sent] == drawer.orders[: len(left.sent)]
    assert [m.capture_ns for m in right.sent] == [t_ns + 1 for t_ns in drawer.orders[: len(right.sent)]]
    assert {(m.camera, m.status, m.data, m.width, m.height) for m in right.sent} == {
        ("right", CameraStatus.LIVE, b"jpeg", 3, 2)
    }


def test_while_nobody_looks_nothing_is_drawn_or_sent():
    left, right = Wire(False), Wire(False)
    drawer, preview = shown(2.0, left, right)
    preview.show_reason("no new views", 10_000 * MS)
    assert drawer.orders == []
    assert left.sent == right.sent == []


def test_one_who_looks_is_enough():
    drawer, _ = shown(1.0, Wire(), Wire(False))
    assert drawer.orders


def test_cameras_slower_than_the_preview_are_shown_whole():
    drawer, _ = shown(3.0, Wire(), Wire(), fps=50.0)
    assert len(drawer.orders) == 90


def test_without_views_the_reason_stands_in_for_the_pictures():
    left, right = Wire(), Wire()
    _, preview = shown(1.0, left, right)
    last = left.sent[-1].capture_ns
    preview.show_reason("camera left gives nothing" + "!" * 500, 5000 * MS)
    for wire in (left, right):
        assert wire.sent[-1].status is CameraStatus.FROZEN
        assert wire.sent[-1].data == b""
        assert wire.sent[-1].reason.startswith("camera left gives nothing")
    assert left.sent[-1].capture_ns >= last


def taken(process, seconds=10.0):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        drawn = process.take()
        if drawn:
            return drawn
        time.sleep(0.002)
    return []


def test_the_process_draws_what_it_is_given_and_ends():
    process = PreviewProcess(CONFIG, (CAMERA, CAMERA))
    try:
        for t_ns in (10 * MS, 20 * MS):
            seen = views(t_ns)
            process.draw(seen, FOUND)
            drawn = taken(process)
            assert [d.taken.capture_ns for d in drawn] == [t_ns, t_ns + 1]
            here = annotate(seen.views[1].current.image, FOUND, 1, CAMERA).astype(int)
            there = simplejpeg.decode_jpeg(drawn[1].jpeg, colorspace="BGR").astype(int)
            assert np.abs(there - here).mean() < 12
    finally:
        process.close()
    assert not process._child.process.is_alive()


def test_who_may_not_schedule_the_process_like_others_ends_it_all_the_same():
    program = [*WITHOUT_RIGHTS, sys.executable, "-c", CLOSING]
    done = subprocess.run(program, check=True, capture_output=True, text=True, timeout=60)
    assert done.stdout.split("\n")[:2] == ["refused", "ended 0"]


def test_a_dead_process_is_told_of_once_and_nobody_waits_for_it():
    process = PreviewProcess(CONFIG, (CAMERA, CAMERA))
    process._child.process.kill()
    process._child.process.join()
    with capture_logs() as logs:
        for k in range(5):
            process.draw(views(k), FOUND)
    process.close()
    assert [entry["event"] for entry in logs] == ["the process that draws the previews died"]
    assert process.take() == []
