"""What v4l2-ctl lists is read, and named where a camera refuses what is asked."""

import shutil
import subprocess

from common.cameras.modes import CameraMode, describe_modes, parse_modes

LISTING = """ioctl: VIDIOC_ENUM_FMT
\tType: Video Capture

\t[0]: 'MJPG' (Motion-JPEG, compressed)
\t\tSize: Discrete 1280x720
\t\t\tInterval: Discrete 0.017s (60.000 fps)
\t\t\tInterval: Discrete 0.033s (30.000 fps)
\t[1]: 'YUYV' (YUYV 4:2:2)
\t\tSize: Discrete 640x480
\t\t\tInterval: Discrete 0.033s (30.000 fps)
\t\tSize: Stepwise 16x16 - 640x480 with step 1/1
"""


def test_the_listing_is_read():
    assert parse_modes(LISTING) == (
        CameraMode("MJPG", 1280, 720, (60.0, 30.0)),
        CameraMode("YUYV", 640, 480, (30.0,)),
    )
    assert parse_modes("Cannot open device /dev/video9") == ()


def test_the_modes_are_named(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _program: "/usr/bin/v4l2-ctl")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: subprocess.CompletedProcess([], 0, LISTING, ""))
    assert describe_modes("/dev/video0") == (
        "choose one of what it offers: MJPG 1280 x 720 at 60/30 fps, YUYV 640 x 480 at 30 fps"
    )


def test_without_the_program_the_cure_names_it(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _program: None)
    assert "v4l2-ctl -d /dev/video0 --list-formats-ext" in describe_modes("/dev/video0")
