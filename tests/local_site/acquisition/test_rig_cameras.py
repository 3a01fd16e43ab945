"""Cameras for a rig: one for each of its own, by its name, or a sentence that lists the available ones."""

from dataclasses import dataclass

import pytest

import local_site.acquisition.rig_cameras
from common.cameras.settings import CameraSettings
from common.config.loading import load_config
from common.errors import CameraError, ConfigError
from local_site.acquisition.rig_cameras import open_rig_cameras
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.config import LocalConfig

ROWS = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 1.0))
REAL = ("operator.left=0", "operator.right=1", "operator.rig=rig.json")


def rig_of(*names):
    cameras = tuple(CameraCalibration(name, ROWS, 0.3) for name in names)
    return Rig(cameras, (0.0,) * 3, (1.0,) * 3, (0.0,) * 3, "made up")


@dataclass
class Opened:
    source: object
    name: str
    settings: CameraSettings
    is_closed: bool = False

    def close(self):
        self.is_closed = True


@pytest.fixture
def opened(monkeypatch):
    """Every camera that was opened; one called broken cannot be."""
    cameras = []

    def open_camera(source, name, _fps, settings):
        if source == "broken":
            raise CameraError(f"camera {name}: cannot open it")
        cameras.append(Opened(source, name, settings))
        return cameras[-1]

    monkeypatch.setattr(local_site.acquisition.rig_cameras, "open_camera", open_camera)
    return cameras


@pytest.mark.parametrize("count", [2, 3, 4])
def test_each_camera_has_its_name_from_the_rig(opened, count):
    names = ("left", "right", "third", "fourth")[:count]
    cameras = open_rig_cameras(rig_of(*names), list(range(count)), 30.0)
    assert cameras == opened
    assert [(camera.source, camera.name) for camera in opened] == list(enumerate(names))


@pytest.mark.parametrize("count", [2, 4])
def test_another_number_than_the_rigs_is_refused_with_its_cameras(opened, count):
    with pytest.raises(CameraError, match=rf"3 cameras \(left, right, third\), but {count} are given"):
        open_rig_cameras(rig_of("left", "right", "third"), list(range(count)), 30.0)
    assert opened == []


def test_a_camera_that_cannot_be_opened_closes_the_others(opened):
    with pytest.raises(CameraError, match="camera third: cannot open"):
        open_rig_cameras(rig_of("left", "right", "third"), [0, 1, "broken"], 30.0)
    assert [camera.is_closed for camera in opened] == [True, True]


def test_the_configuration_takes_up_to_four_in_the_rigs_order():
    operator = load_config(LocalConfig, None, (*REAL, 'operator.also=["/dev/video4", 3]')).operator
    assert operator.sources == (0, 1, "/dev/video4", 3)
    assert load_config(LocalConfig, None, REAL).operator.sources == (0, 1)


def test_each_camera_has_the_settings_of_all_and_its_own_over_them():
    lines = ("operator.latency_ms=40", "operator.cameras.gain=7", "operator.cameras.exposure_ms=4")
    operator = load_config(LocalConfig, None, (*REAL, *lines, "operator.camera.right.gain=9")).operator
    settings = operator.settings_of(["left", "right"])
    assert settings["left"] == CameraSettings(latency_ms=40.0, gain=7, exposure_ms=4.0)
    assert settings["right"] == CameraSettings(latency_ms=40.0, gain=9, exposure_ms=4.0)
    with pytest.raises(ConfigError, match=r"operator\.camera\.right: .*its cameras are left, middle"):
        operator.settings_of(["left", "middle"])


def test_all_settings_of_unknown_cameras_are_told_at_once():
    lines = ("operator.camera.rihgt.gain=9", "operator.camera.front.gain=9")
    operator = load_config(LocalConfig, None, (*REAL, *lines)).operator
    with pytest.raises(ConfigError) as caught:
        operator.settings_of(["left", "right"])
    assert str(caught.value).splitlines() == [
        "operator.camera.rihgt: the rig has no such camera; did you mean right?",
        "operator.camera.front: the rig has no such camera; its cameras are left, right",
    ]


def test_a_camera_is_opened_with_the_settings_of_its_name(opened):
    by_name = {"right": CameraSettings(gain=3)}
    open_rig_cameras(rig_of("left", "right"), [0, 1], 30.0, by_name)
    assert [camera.settings for camera in opened] == [CameraSettings(), CameraSettings(gain=3)]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ((*REAL, "operator.also=[2, 3, 4]"), "give a list of at most 2"),
        ((*REAL, 'operator.also=[""]'), "words of at least 1 character"),
        ((*REAL, "operator.cameras.width_px=640"), "give both or neither"),
        ((*REAL, "operator.camera.left.gian=3"), "gian"),
        (("operator.also=[2]",), "simulated operator brings its own"),
    ],
)
def test_more_cameras_than_there_can_be_are_refused(settings, words):
    with pytest.raises(ConfigError, match=words):
        load_config(LocalConfig, None, settings)
