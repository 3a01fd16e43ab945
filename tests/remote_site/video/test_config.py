"""A view's name is one wherever it goes: topics, files, the page."""

import pytest

from common.config.loading import load_config
from remote_site.config import RemoteConfig
from remote_site.video.config import CameraConfig


@pytest.mark.parametrize("name", ["front_high", "Kamera über dem Tisch", "[red]", '"side"'])
def test_an_ordinary_name_is_taken(name):
    assert CameraConfig(name=name).name == name


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("side\nfront", r"characters that do not show: 'side\\nfront'"), ("a/calibration", "'a/calibration' has a slash")],
)
def test_a_name_that_would_be_another_topic_or_line_is_refused(name, wrong):
    with pytest.raises(ValueError, match=f"name: .*{wrong}"):
        CameraConfig(name=name)


def test_a_cell_may_have_no_camera_where_the_operator_sees_the_arm_itself(tmp_path):
    file = tmp_path / "remote.toml"
    file.write_text("[video]\ncameras = []\n")
    assert load_config(RemoteConfig, file).video.cameras == ()
