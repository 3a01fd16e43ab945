"""A calibration is for pictures of one size, which need not be that of simulated views."""

import numpy as np
import pytest
from structlog.testing import capture_logs

from common.cameras.camera import Frame
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.request_server import describe
from remote_site.video.calibration import FittingPictures
from remote_site.video.config import CameraConfig, VideoConfig

PROJECTION = (1.0,) * 12
HIGH = CameraConfig(name="high", source="0", projection=PROJECTION, size_px=(1280, 720))
LOW = CameraConfig(name="low", source="1", projection=PROJECTION)
FREE = CameraConfig(name="free", source="2")
VIDEO = VideoConfig(cameras=(HIGH, LOW, FREE))


def picture(width: int, height: int) -> Frame:
    return Frame(np.zeros((height, width, 3), np.uint8), 0, 0)


def test_a_camera_is_described_with_the_size_that_its_projection_is_for() -> None:
    config = RemoteConfig(video=VIDEO)
    described = describe(config, *load_arm(config.robot)).cameras
    assert {camera.name: (camera.width, camera.height) for camera in described} == {
        "high": (1280, 720),
        "low": (640, 480),
        "free": (640, 480),
    }


def test_a_picture_of_another_size_is_told_once_with_the_cure() -> None:
    pictures = FittingPictures(VIDEO)
    with capture_logs() as log:
        assert pictures.fits("high", picture(1280, 720))
        assert pictures.fits("low", picture(640, 480))
        assert log == []
        assert not any(pictures.fits("low", picture(1280, 720)) for _ in range(3))
        assert not any(pictures.fits("free", picture(1280, 720)) for _ in range(3))
        assert pictures.fits("low", picture(640, 480))
    (said,) = log
    assert said["view"] == "low"
    assert said["reason"] == "its pictures have 1280 x 720 pixels, and its projection is for 640 x 480"
    assert "size_px = [1280, 720]" in said["cure"]


def test_a_size_without_a_projection_is_refused() -> None:
    with pytest.raises(ValueError, match="give projection, too"):
        CameraConfig(name="high", size_px=(1280, 720))
