"""The options of the A465's driver, in the table `driver.options`."""

from collections.abc import Mapping
from typing import Annotated

import msgspec
from msgspec import Meta

from common.errors import ConfigError
from remote_site.drivers.registry import Option, check_options


class C500cConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The serial line to the controller, its pace and the gripper's force."""

    port: Annotated[str, Meta(description="serial device, as /dev/ttyUSB0")] = ""
    baud: Annotated[int, Meta(ge=38400, le=115200, description="57600 as the C500C's console")] = 57600
    rate_hz: Annotated[float, Meta(ge=10, le=20, description="setpoints per second; more than 20 overrun the line")] = (
        15.0
    )
    answer_ms: Annotated[
        float, Meta(ge=20, le=200, description="without an answer for this long a request is repeated")
    ] = 25.0
    silent_ms: Annotated[
        float, Meta(ge=100, le=400, description="no answer for this long is a fault of the link; so are four periods")
    ] = 200.0
    grip_percent: Annotated[int, Meta(ge=1, le=100, description="force with which the gripper closes")] = 50
    hold_percent: Annotated[
        int, Meta(ge=1, le=75, description="force after strong_grip_s; more overheats the gripper")
    ] = 50
    strong_grip_s: Annotated[float, Meta(ge=0, le=15, description="how long a force above hold_percent lasts, s")] = (
        10.0
    )


def c500c_options(options: Mapping[str, Option]) -> C500cConfig:
    """The table `driver.options`; ConfigError for what is wrong in it, or where it names no serial line."""
    config = check_options(C500cConfig, options)
    if not config.port:
        raise ConfigError("the c500c driver needs its serial line: set driver.options.port, or start with --emulate")
    return config
