"""The options of the FR3's driver, in the table `driver.options`."""

from collections.abc import Mapping
from typing import Annotated

import msgspec
from msgspec import Meta

from common.errors import ConfigError
from remote_site.drivers.registry import Option, check_options


class FrankaConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the robot is, how late its arm follows setpoints, and its gripper."""

    host: Annotated[str, Meta(description="the robot's address, as 172.16.0.2")] = ""
    realtime: Annotated[
        bool, Meta(description="libfranka refuses a kernel without real time; false only against a simulator")
    ] = True
    follow_ms: Annotated[
        float, Meta(ge=1, le=800, description="the arm's own lag behind what it is sent, at most, ms")
    ] = 60.0
    gripper: Annotated[bool, Meta(description="a Franka Hand is on the arm, with its own server")] = True
    gripper_speed_m_s: Annotated[float, Meta(gt=0, le=0.1, description="speed of its fingers together, m/s")] = 0.1


def franka_options(options: Mapping[str, Option]) -> FrankaConfig:
    """The table `driver.options`; ConfigError for what is wrong in it, or where it names no robot."""
    config = check_options(FrankaConfig, options)
    if not config.host:
        raise ConfigError(
            "the franka driver needs the robot's address: set driver.options.host, or start with --emulate"
        )
    return config
