"""What a remote site refuses before it starts, and what an unordered end leaves behind."""

import msgspec
import pytest

from common.errors import ConfigError, ModelError
from remote_site.app import without_automatic_engagement
from remote_site.checks import check_robot
from remote_site.config import EngagementMode, MappingConfig, RemoteConfig, RobotConfig
from remote_site.running_mark import RunningMark


def test_the_defaults_are_right():
    check_robot(RemoteConfig())


@pytest.mark.parametrize(
    ("robot", "error", "words"),
    [
        (RobotConfig(start_deg=(0, 0, 500, 0, 0, 0)), ConfigError, "joint_3 at 500 deg is outside -109.0 to 109.0"),
        (RobotConfig(start_deg=(0, 0, 0)), ConfigError, "3 angles for 6 joints"),
        (RobotConfig(model="ur5"), ModelError, "neither a built-in model \\(a465, humanoid\\) nor the file"),
        (RobotConfig(position_deg={"joint_1": (-400, 400)}), ConfigError, "limits only tighten"),
    ],
)
def test_an_arm_that_cannot_start_is_refused(robot, error, words):
    with pytest.raises(error, match=words):
        check_robot(RemoteConfig(robot=robot))


def test_a_mirrored_mapping_is_refused():
    mirrored = MappingConfig(base_R_operator=((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    with pytest.raises(ConfigError, match="not a proper rotation"):
        check_robot(RemoteConfig(mapping=mirrored))


def test_a_mark_that_still_stands_tells_of_an_unordered_end(tmp_path, monkeypatch):
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path))
    first = RunningMark("cell", "tcp/127.0.0.1:7447")
    assert not first.set()
    assert RunningMark("cell", "tcp/127.0.0.1:7447").set()
    assert not RunningMark("cell", "tcp/127.0.0.1:7449").set()
    first.clear()
    assert not RunningMark("cell", "tcp/127.0.0.1:7447").set()


def test_without_automatic_engagement_all_else_stays():
    config = without_automatic_engagement(RemoteConfig(cell="lab"))
    assert config.engagement.mode is EngagementMode.ON_REQUEST
    assert msgspec.structs.replace(config, engagement=RemoteConfig().engagement) == RemoteConfig(cell="lab")
