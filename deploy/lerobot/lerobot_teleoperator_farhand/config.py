"""What LeRobot is told of a Farhand cell: where it is, how it is protected, and what an action consists of."""

import re
from dataclasses import dataclass, field

from lerobot.teleoperators.config import TeleoperatorConfig

JOINTS, TOOL = "joints", "tool"
ON_THIS_HOST = re.compile(r"tcp/(127\.0\.0\.1|localhost|\[::1\]):\d+")


@TeleoperatorConfig.register_subclass("farhand")
@dataclass(kw_only=True)
class FarhandTeleopConfig(TeleoperatorConfig):
    """A cell `cell` whose remote site, or a router, is at `remote`.

    `ca`, `certificate` and `key` are PEM files, all three for tls/ and quic/ endpoints; a viewer's suffice. An endpoint
    without them is on this host.
    `action` is "joints" (rad; `joints` names them, in the cell's order) or "tool" (m, and a quaternion x, y, z, w, in
    the frame of the arm's base). The gripper is between `gripper_closed` and `gripper_open`. A state older than
    `max_age_ms` is refused.
    """

    cell: str = "cell"
    remote: str = "tcp/127.0.0.1:7447"
    ca: str = ""
    certificate: str = ""
    key: str = ""
    action: str = JOINTS
    joints: list[str] = field(default_factory=list)
    gripper: bool = True
    gripper_closed: float = 0.0
    gripper_open: float = 1.0
    max_age_ms: float = 200.0
    connect_timeout_s: float = 10.0

    def __post_init__(self) -> None:
        if self.action not in (JOINTS, TOOL):
            raise ValueError(f"action is {self.action!r}: write {JOINTS!r} or {TOOL!r}")
        if self.action == JOINTS and not self.joints:
            raise ValueError("joints is empty: name the cell's joints in their order, as its page or its URDF does")
        if len({bool(self.ca), bool(self.certificate), bool(self.key)}) != 1:
            raise ValueError("ca, certificate and key belong together: give all three, or none")
        secured = self.remote.startswith(("tls/", "quic/"))
        if not secured and not ON_THIS_HOST.fullmatch(self.remote):
            raise ValueError(
                f"{self.remote} is refused: without certificates anybody on the network could move your robot; write "
                "tls/HOST:PORT with ca, certificate and key"
            )
        if secured != bool(self.ca):
            raise ValueError(
                f"{self.remote} needs certificates: give ca, certificate and key"
                if secured
                else f"{self.remote} uses no certificates: write tls/HOST:PORT, or leave ca, certificate and key out"
            )
