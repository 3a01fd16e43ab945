"""A robot is emulated for an arm of its own number of joints alone."""

import msgspec
import pytest

from common.errors import ConfigError
from common.process.children import Children
from remote_site.config import RemoteConfig
from remote_site.runtime.emulated_robot import start_robot

CONFIG = RemoteConfig()


@pytest.mark.parametrize(
    ("driver", "joints", "sentence"),
    [("franka", 6, "has 6 joints, and the robot that is emulated for franka has 7"), ("c500c", 7, "for c500c has 6")],
)
def test_an_arm_of_other_joints_is_refused_before_anything_starts(driver: str, joints: int, sentence: str) -> None:
    robot = msgspec.structs.replace(CONFIG.robot, start_deg=(0.0,) * joints)
    chosen = msgspec.structs.replace(CONFIG.driver, name=driver, emulate=True)
    children = Children("remote")
    try:
        with pytest.raises(ConfigError, match=sentence):
            start_robot(msgspec.structs.replace(CONFIG, robot=robot, driver=chosen), children)
    finally:
        children.end()
