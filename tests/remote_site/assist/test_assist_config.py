"""Mistakes in [assist], each named with its cure."""

import re

import msgspec
import pytest
from msgspec.structs import replace

from remote_site.assist.config import AssistConfig, AssistTargetConfig
from remote_site.assist.families import MarkerFamily
from remote_site.config import RemoteConfig
from remote_site.simulation.config import MarkerConfig
from tests.remote_site.assist.sightings import BLOCK, CONFIG


@pytest.mark.parametrize(
    ("targets", "message"),
    [
        ((BLOCK, BLOCK), "two targets are named 'block': give each a name of its own"),
        ((replace(BLOCK, marker=50),), "aruco_4x4_50 has markers 0 to 49, not 50"),
        ((BLOCK, replace(BLOCK, name="side", size_mm=30)), "give all of its targets the same size_mm"),
    ],
)
def test_targets_that_contradict_are_refused(targets: tuple[AssistTargetConfig, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        AssistConfig(targets=targets)


def test_a_pose_has_to_be_finite() -> None:
    with pytest.raises(ValueError, match="'block': xyz_mm and rpy_deg must be finite"):
        replace(BLOCK, xyz_mm=(0.0, float("nan"), 0.0))


def test_a_grasp_and_a_place_may_share_a_marker() -> None:
    config = AssistConfig(targets=(BLOCK, replace(BLOCK, name="side", kind="place")))
    assert config.marker_sizes_m == {BLOCK.marker: 0.04}


def test_targets_without_calibrated_views_are_refused_with_the_cure() -> None:
    with pytest.raises(ValueError, match=re.escape("[[video.cameras]], or for simulated views set video.calibrated")):
        RemoteConfig(assist=CONFIG)
    on_tool = tuple(replace(c, projection=(1.0,) * 12, on_tool=True) for c in RemoteConfig().video.cameras[:1])
    RemoteConfig(assist=CONFIG, video=replace(RemoteConfig().video, cameras=on_tool))


def test_an_unknown_family_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="Invalid enum value"):
        msgspec.convert({"family": "qr"}, AssistConfig)


def test_a_simulated_marker_of_no_family_is_refused() -> None:
    with pytest.raises(ValueError, match="apriltag_25h9 has markers 0 to 34, not 35"):
        MarkerConfig(
            family=MarkerFamily.APRILTAG_25H9, marker=35, size_mm=40, xyz_mm=(0.0, 0.0, 0.0), rpy_deg=(0.0, 0.0, 0.0)
        )
